// The last step of the reduction: chunks in index order, in double.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/exec/normal_equations.h"

namespace kt::exec {

NormalEquations ReductionWorkspace::sum(int64_t count) {
  const int64_t used = chunks(count);
  KT_CHECK(used * kReductionTerms <= chunk_terms_.size(), "reduction larger than its workspace");
  chunk_terms_.download(std::span(host_terms_).first(static_cast<size_t>(used * kReductionTerms)));
  double sums[kReductionTerms] = {};
  for (int64_t chunk = 0; chunk < used; ++chunk) {
    for (int k = 0; k < kReductionTerms; ++k)
      sums[k] += host_terms_[static_cast<size_t>(chunk * kReductionTerms + k)];
  }
  NormalEquations equations;
  int k = 0;
  for (int i = 0; i < 6; ++i) {
    for (int j = i; j < 6; ++j) equations.A[i][j] = equations.A[j][i] = sums[k++];
    equations.b[i] = sums[21 + i];
  }
  equations.weighted_squares = sums[27];
  equations.weights = sums[28];
  equations.count = static_cast<int64_t>(sums[29]);
  return equations;
}

}  // namespace kt::exec
