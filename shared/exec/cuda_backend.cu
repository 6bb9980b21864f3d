// CUDA memory, and sorted lists through CUB.
// SPDX-License-Identifier: BSD-3-Clause
#include <cub/cub.cuh>
#include <thrust/iterator/counting_iterator.h>

#include "shared/exec/cuda_backend.h"
#include "shared/exec/cuda_launch.cuh"

namespace kt::exec::cuda_backend {
namespace {

// Scratch of CUB, grown on demand and kept: lists are built every frame, by one host thread.
class Scratch {
 public:
  ~Scratch() { cudaFree(pointer_); }
  void* reserve(size_t bytes) {
    if (bytes > bytes_) {
      cudaFree(pointer_);
      pointer_ = nullptr;
      check_cuda(cudaMalloc(&pointer_, bytes), "allocation");
      bytes_ = bytes;
    }
    return pointer_;
  }

 private:
  void* pointer_ = nullptr;
  size_t bytes_ = 0;
};

}  // namespace

std::string problem() {
  int devices = 0;
  const cudaError_t status = cudaGetDeviceCount(&devices);
  if (status != cudaSuccess)
    return std::string("no usable NVIDIA driver or GPU (") + cudaGetErrorString(status) + ")";
  return devices > 0 ? "" : "this machine has no NVIDIA GPU";
}

void* allocate_zeroed(size_t bytes) {
  void* pointer = nullptr;
  if (cudaMalloc(&pointer, bytes) != cudaSuccess) {
    cudaGetLastError();
    throw Error("not enough GPU memory for " + std::to_string(bytes >> 20) +
                " MiB: use a smaller volume (volume.resolution)");
  }
  check_cuda(cudaMemset(pointer, 0, bytes), "memset");
  return pointer;
}

void release(void* pointer) noexcept { cudaFree(pointer); }
void copy_to_device(void* to, const void* from, size_t bytes) {
  check_cuda(cudaMemcpy(to, from, bytes, cudaMemcpyHostToDevice), "upload");
}
void copy_to_host(void* to, const void* from, size_t bytes) {
  check_cuda(cudaMemcpy(to, from, bytes, cudaMemcpyDeviceToHost), "download");
}

int64_t compact_flags(const uint8_t* flags, int64_t count, int32_t* indices) {
  static thread_local Scratch scratch;
  static thread_local Scratch selected;
  auto* selected_count = static_cast<int64_t*>(selected.reserve(sizeof(int64_t)));
  const thrust::counting_iterator<int32_t> all(0);
  size_t bytes = 0;
  check_cuda(cub::DeviceSelect::Flagged(nullptr, bytes, all, flags, indices, selected_count, count),
             "select");
  check_cuda(
      cub::DeviceSelect::Flagged(scratch.reserve(bytes), bytes, all, flags, indices, selected_count, count),
      "select");
  int64_t listed = 0;
  copy_to_host(&listed, selected_count, sizeof(listed));
  return listed;
}

int64_t exclusive_scan(const int32_t* counts, int64_t count, int32_t* offsets) {
  if (count == 0) return 0;
  static thread_local Scratch scratch;
  size_t bytes = 0;
  check_cuda(cub::DeviceScan::ExclusiveSum(nullptr, bytes, counts, offsets, count), "scan");
  check_cuda(cub::DeviceScan::ExclusiveSum(scratch.reserve(bytes), bytes, counts, offsets, count), "scan");
  int32_t last_offset = 0, last_count = 0;
  copy_to_host(&last_offset, offsets + count - 1, sizeof(int32_t));
  copy_to_host(&last_count, counts + count - 1, sizeof(int32_t));
  return int64_t{last_offset} + last_count;
}

}  // namespace kt::exec::cuda_backend
