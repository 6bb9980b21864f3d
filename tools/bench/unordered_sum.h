// Sums residuals in no particular order, in float: what exec::reduce_normal_equations is measured against.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mutex>
#include <vector>

#include "shared/exec/buffer.h"
#include "tools/bench/bench_kernel.h"

namespace kt::bench {

#if defined(KT_HAVE_CUDA)
/// Adds to `sums`, on the GPU; defined in bench_kernels.cu.
void launch_unordered_sum(int64_t count, const PairResidual<false>& functor, float* sums);
#endif

/// The terms of ReductionTerms<6>, whose last bits differ from run to run. `sums` holds as many on the
/// device.
inline std::vector<float> unordered_sum(const exec::Device& device, int64_t count,
                                        const PairResidual<false>& functor, exec::Buffer<float>& sums) {
  constexpr int kTerms = exec::ReductionTerms<6>::kTerms;
  std::vector<float> total(kTerms);
#if defined(KT_HAVE_CUDA)
  if (device.is_cuda()) {
    sums.upload(total);
    launch_unordered_sum(count, functor, sums.data());
    return sums.downloaded();
  }
#endif
  std::mutex mutex;
  device.pool().run(exec::ReductionWorkspace::chunks(count), [&](int64_t chunk) {
    const PairResidual<false> f = functor;
    float terms[kTerms] = {};
    const int64_t end = std::min(count, (chunk + 1) * exec::kReductionChunk);
    for (int64_t i = chunk * exec::kReductionChunk; i < end; ++i) {
      const exec::ResidualRow row = f(i);
      if (row.weight > 0) exec::add_products(row, terms);
    }
    const std::lock_guard lock(mutex);
    for (int k = 0; k < kTerms; ++k) total[static_cast<size_t>(k)] += terms[k];
  });
  sums.upload(total);
  return total;
}

}  // namespace kt::bench
