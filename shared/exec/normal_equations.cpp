// The last step of the reduction: chunks in index order, in double.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/exec/normal_equations.h"

namespace kt::exec {

void ReductionWorkspace::add_chunks(int64_t chunks, int terms, double* sums) {
  chunk_terms_.download(std::span(host_terms_).first(static_cast<size_t>(chunks * terms)));
  for (int64_t chunk = 0; chunk < chunks; ++chunk) {
    for (int k = 0; k < terms; ++k) sums[k] += host_terms_[static_cast<size_t>(chunk * terms + k)];
  }
}

}  // namespace kt::exec
