// The last step of the reduction: chunks in index order, in double.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/exec/normal_equations.h"

namespace kt::exec {

int64_t ReductionWorkspace::start_download(int64_t terms) {
  chunk_terms_.start_download(terms, host_terms_);
  return ++starts_;
}

void ReductionWorkspace::add_chunks(int64_t start, int64_t chunks, int terms, double* sums) const {
  KT_CHECK(start == starts_, "another sum has been started in the workspace of this one");
  wait(device_);
  for (int64_t chunk = 0; chunk < chunks; ++chunk) {
    for (int k = 0; k < terms; ++k) sums[k] += host_terms_.data()[chunk * terms + k];
  }
}

}  // namespace kt::exec
