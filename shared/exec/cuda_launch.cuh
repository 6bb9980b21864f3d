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

// One warp per chunk: its 32 threads are the 32 lanes of the reduction.
template <typename Functor>
__global__ void reduce_kernel(int64_t count, Functor functor, float* chunk_terms) {
  const int64_t chunk = (static_cast<int64_t>(blockIdx.x) * blockDim.x + threadIdx.x) / kReductionLanes;
  const int lane = static_cast<int>(threadIdx.x % kReductionLanes);
  const int64_t begin = chunk * kReductionChunk;
  if (begin >= count) return;  // whole warps leave together
  const int64_t end = begin + kReductionChunk < count ? begin + kReductionChunk : count;
  constexpr int kTerms = ReductionTerms<kUnknownsOf<Functor>>::kTerms;
  float terms[kTerms] = {};
  for (int64_t i = begin + lane; i < end; i += kReductionLanes) {
    const auto row = functor(i);
    if (row.weight > 0) add_products(row, terms);
  }
  for (int k = 0; k < kTerms; ++k) {
    for (int half = kReductionLanes / 2; half > 0; half /= 2)
      terms[k] += __shfl_down_sync(0xffffffffu, terms[k], half);
    if (lane == 0) chunk_terms[chunk * kTerms + k] = terms[k];
  }
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
  constexpr int kThreads = 128;
  const int64_t threads = ReductionWorkspace::chunks(count) * kReductionLanes;
  const auto blocks = static_cast<unsigned>((threads + kThreads - 1) / kThreads);
  reduce_kernel<<<blocks, kThreads, 0, stream()>>>(count, functor, chunk_terms);
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
