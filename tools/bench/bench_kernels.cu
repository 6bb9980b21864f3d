// CUDA instantiations of the benches' kernels, and the sum in no order that the one with an order is compared
// to.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/exec/cuda_launch.cuh"
#include "tools/bench/bench_kernel.h"
#include "tools/bench/unordered_sum.h"

KT_INSTANTIATE_FOR_EACH(kt::bench::Triad);
KT_INSTANTIATE_FOR_EACH(kt::bench::RememberRows);
KT_INSTANTIATE_FOR_EACH(kt::bench::CountChangedRows);
KT_INSTANTIATE_REDUCE(kt::bench::PairResidual<false>);

namespace kt::bench {
namespace {

// As one would write it were equal bits no concern: the grid strides over the residuals, a warp adds up, and
// whichever comes first adds to the total.
template <typename Functor>
__global__ void unordered_sum_kernel(int64_t count, Functor functor, float* sums) {
  constexpr int kTerms = exec::ReductionTerms<exec::kUnknownsOf<Functor>>::kTerms;
  float terms[kTerms] = {};
  const int64_t stride = static_cast<int64_t>(gridDim.x) * blockDim.x;
  for (int64_t i = static_cast<int64_t>(blockIdx.x) * blockDim.x + threadIdx.x; i < count; i += stride) {
    const auto row = functor(i);
    if (row.weight > 0) exec::add_products(row, terms);
  }
  for (int k = 0; k < kTerms; ++k) {
    for (int half = 16; half > 0; half /= 2) terms[k] += __shfl_down_sync(0xffffffffu, terms[k], half);
    if (threadIdx.x % 32 == 0) atomicAdd(&sums[k], terms[k]);
  }
}

}  // namespace

void launch_unordered_sum(int64_t count, const PairResidual<false>& functor, float* sums) {
  if (count <= 0) return;
  constexpr int64_t kPerThread = 16;
  unordered_sum_kernel<<<exec::blocks_for((count + kPerThread - 1) / kPerThread), exec::kThreadsPerBlock, 0,
                         exec::stream()>>>(count, functor, sums);
  exec::check_cuda(cudaGetLastError(), "launch");
}

}  // namespace kt::bench
