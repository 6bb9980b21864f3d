// The CUDA executor: generic kernels that call a functor, and the macros that instantiate them for one.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cuda_runtime.h>

#include "shared/core/check.h"
#include "shared/exec/cuda_errors.h"
#include "shared/exec/for_each.h"
#include "shared/exec/normal_equations.h"

namespace kt::exec {

/// Every launch, copy and memset goes into this one stream: they are done in the order of the calls. Defined
/// in cuda_backend.cu.
cudaStream_t stream();

/// Throws kt::Error where `call` failed.
inline void check_cuda(cudaError_t status, const char* call) {
  if (status != cudaSuccess) throw Error(gpu_failure(call, cudaGetErrorString(status)));
}

template <typename Functor>
__global__ void for_each_kernel(int64_t count, Functor functor) {
  const int64_t i = static_cast<int64_t>(blockIdx.x) * blockDim.x + threadIdx.x;
  if (i < count) functor(i);
}

template <typename Functor>
__global__ void for_each_lane_kernel(int64_t count, Functor functor) {
  const int64_t i = static_cast<int64_t>(blockIdx.x) * blockDim.x + threadIdx.x;
  if (i < count) functor.template run<1>(i);
}

template <typename Functor>
__global__ void for_each_pixel_kernel(int width, int height, Functor functor) {
  const int u = static_cast<int>(blockIdx.x * blockDim.x + threadIdx.x);
  const int v = static_cast<int>(blockIdx.y * blockDim.y + threadIdx.y);
  if (u < width && v < height) functor(u, v);
}

// Calls use(std::integral_constant<int, row>{}) for the one `row` below kRows that a warp has.
template <int kRows, typename Use>
__device__ void for_row(int row, const Use& use) {
  [&]<int... kRow>(std::integer_sequence<int, kRow...>) {
    ((row == kRow ? use(std::integral_constant<int, kRow>{}) : void()), ...);
  }
  (std::make_integer_sequence<int, kRows>{});
}

// One block per chunk, stage by stage: all its threads compute residuals, for whose loads they wait side by
// side, and then warp i adds row i of the terms, its 32 threads being the 32 lanes of the reduction.
inline constexpr int kReductionThreads = 512, kReductionStage = 1024;

template <typename Functor>
__global__ void __launch_bounds__(kReductionThreads)
    reduce_kernel(int64_t count, Functor functor, float* chunk_terms) {
  constexpr int kUnknowns = kUnknownsOf<Functor>;
  using At = ReductionTerms<kUnknowns>;
  static_assert(At::kRows <= kReductionThreads / kReductionLanes && kReductionChunk % kReductionStage == 0);
  __shared__ ResidualRowsOf<kUnknowns, kReductionStage> stage;
  const int warp = static_cast<int>(threadIdx.x) / kReductionLanes;
  const int lane = static_cast<int>(threadIdx.x) % kReductionLanes;
  const int64_t chunk_begin = static_cast<int64_t>(blockIdx.x) * kReductionChunk;
  float terms[At::kMostOfRow] = {};
  for (int64_t begin = chunk_begin; begin < chunk_begin + kReductionChunk; begin += kReductionStage) {
    for (int k = static_cast<int>(threadIdx.x); k < kReductionStage; k += kReductionThreads)
      stage.set(k, begin + k < count ? functor(begin + k) : ResidualRowOf<kUnknowns>{});
    __syncthreads();
    for_row<At::kRows>(warp, [&](auto row) {
      for (int k = lane; k < kReductionStage; k += kReductionLanes)
        add_row_products<decltype(row)::value, 1>(stage.at(k), terms);
    });
    __syncthreads();
  }
  for_row<At::kRows>(warp, [&](auto row) {
    constexpr int kRow = decltype(row)::value;
    for (int t = 0; t < At::of_row(kRow); ++t) {
      for (int half = kReductionLanes / 2; half > 0; half /= 2)
        terms[t] += __shfl_down_sync(0xffffffffu, terms[t], half);
      if (lane == 0) chunk_terms[blockIdx.x * At::kTerms + At::row(kRow) + t] = terms[t];
    }
  });
}

inline constexpr int kThreadsPerBlock = 256;

inline unsigned blocks_for(int64_t threads) {
  return static_cast<unsigned>((threads + kThreadsPerBlock - 1) / kThreadsPerBlock);
}

template <typename Functor>
void launch_for_each(int64_t count, const Functor& functor) {
  if (count <= 0) return;
  for_each_kernel<<<blocks_for(count), kThreadsPerBlock, 0, stream()>>>(count, functor);
  check_cuda(cudaGetLastError(), "launch");
}

template <typename Functor>
void launch_for_each_lane(int64_t count, const Functor& functor) {
  if (count <= 0) return;
  for_each_lane_kernel<<<blocks_for(count), kThreadsPerBlock, 0, stream()>>>(count, functor);
  check_cuda(cudaGetLastError(), "launch");
}

template <typename Functor>
void launch_for_each_pixel(int width, int height, const Functor& functor) {
  if (width <= 0 || height <= 0) return;
  const dim3 threads(32, 8);
  const dim3 blocks((width + threads.x - 1) / threads.x, (height + threads.y - 1) / threads.y);
  for_each_pixel_kernel<<<blocks, threads, 0, stream()>>>(width, height, functor);
  check_cuda(cudaGetLastError(), "launch");
}

template <typename Functor>
void launch_reduce(int64_t count, const Functor& functor, float* chunk_terms) {
  if (count <= 0) return;
  const auto blocks = static_cast<unsigned>(ReductionWorkspace::chunks(count));
  reduce_kernel<<<blocks, kReductionThreads, 0, stream()>>>(count, functor, chunk_terms);
  check_cuda(cudaGetLastError(), "launch");
}

}  // namespace kt::exec

#define KT_INSTANTIATE_FOR_EACH(Functor) \
  template void kt::exec::launch_for_each<Functor>(int64_t, const Functor&)
#define KT_INSTANTIATE_FOR_EACH_LANE(Functor) \
  template void kt::exec::launch_for_each_lane<Functor>(int64_t, const Functor&)
#define KT_INSTANTIATE_FOR_EACH_PIXEL(Functor) \
  template void kt::exec::launch_for_each_pixel<Functor>(int, int, const Functor&)
#define KT_INSTANTIATE_REDUCE(Functor) \
  template void kt::exec::launch_reduce<Functor>(int64_t, const Functor&, float*)
