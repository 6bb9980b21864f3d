// The one stream, CUDA memory and copies, and sorted lists through CUB.
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cstring>
#include <cub/cub.cuh>
#include <cuda/std/functional>
#include <mutex>
#include <thrust/iterator/counting_iterator.h>

#include "shared/exec/cuda_backend.h"
#include "shared/exec/cuda_launch.cuh"

namespace kt::exec {
namespace {

// What all work on the GPU shares, for one host thread at a time. Copies go through page-locked blocks: only
// from and to such memory does the GPU copy by itself.
class Context {
 public:
  // Made at first use and never unmade: at the end of the program the driver may be gone before static
  // objects are, and takes all of this back itself.
  static Context& get() {
    static Context* const context = new Context;
    return *context;
  }

  std::mutex& turn() { return turn_; }
  cudaStream_t stream() const { return stream_; }

  void upload(void* to, const void* from, size_t bytes) {
    for (size_t done = 0, piece = 0; done < bytes; done += piece) {
      piece = std::min(bytes - done, kBlockBytes);
      Block& block = blocks_[next_block_++ % kBlocks];
      // The copy before this one from the block must have left it.
      check_cuda(cudaEventSynchronize(block.left), "upload");
      std::memcpy(block.bytes, static_cast<const char*>(from) + done, piece);
      check_cuda(
          cudaMemcpyAsync(static_cast<char*>(to) + done, block.bytes, piece, cudaMemcpyHostToDevice, stream_),
          "upload");
      check_cuda(cudaEventRecord(block.left, stream_), "upload");
    }
  }

  void download(void* to, const void* from, size_t bytes) {
    // An upload from the block that is still under way comes first, for both are in one stream.
    char* block = blocks_[0].bytes;
    for (size_t done = 0, piece = 0; done < bytes; done += piece) {
      piece = std::min(bytes - done, kBlockBytes);
      check_cuda(cudaMemcpyAsync(block, static_cast<const char*>(from) + done, piece, cudaMemcpyDeviceToHost,
                                 stream_),
                 "download");
      check_cuda(cudaStreamSynchronize(stream_), "download");
      std::memcpy(static_cast<char*>(to) + done, block, piece);
    }
  }

  // Memory for CUB, grown in large steps and kept: lists are built every frame.
  void* scratch(size_t bytes) {
    if (bytes > scratch_bytes_) {
      constexpr size_t kStep = size_t{1} << 20;
      cuda_backend::release(scratch_);
      scratch_ = nullptr;
      scratch_bytes_ = 0;
      const size_t grown = (bytes + kStep - 1) / kStep * kStep;
      scratch_ = cuda_backend::allocate_zeroed(grown);
      scratch_bytes_ = grown;
    }
    return scratch_;
  }
  // Where a list's length or a total is left on the device.
  int64_t* result() const { return result_; }
  int64_t downloaded_result() {
    int64_t value = 0;
    download(&value, result_, sizeof(value));
    return value;
  }

 private:
  static constexpr size_t kBlockBytes = size_t{4} << 20;
  static constexpr size_t kBlocks = 2;  // one is filled while the GPU copies from the other
  struct Block {
    char* bytes = nullptr;
    cudaEvent_t left = nullptr;
  };

  Context() {
    check_cuda(cudaStreamCreateWithFlags(&stream_, cudaStreamNonBlocking), "start");
    for (Block& block : blocks_) {
      check_cuda(cudaMallocHost(reinterpret_cast<void**>(&block.bytes), kBlockBytes),
                 "allocation of page-locked memory");
      check_cuda(cudaEventCreateWithFlags(&block.left, cudaEventDisableTiming), "start");
    }
    check_cuda(cudaMalloc(reinterpret_cast<void**>(&result_), sizeof(*result_)), "allocation");
  }

  std::mutex turn_;
  cudaStream_t stream_ = nullptr;
  Block blocks_[kBlocks];
  size_t next_block_ = 0;
  void* scratch_ = nullptr;
  size_t scratch_bytes_ = 0;
  int64_t* result_ = nullptr;
};

__global__ void any_kernel() {}

GpuProbe probe() {
  GpuProbe probe;
  cudaDriverGetVersion(&probe.driver_cuda_version);  // 0 without a driver
  cudaRuntimeGetVersion(&probe.build_cuda_version);
  int devices = 0;
  cudaError_t status = cudaGetDeviceCount(&devices);
  if (status == cudaSuccess && devices == 0) status = cudaErrorNoDevice;
  if (status == cudaSuccess) {
    cudaDeviceProp properties;
    status = cudaGetDeviceProperties(&properties, 0);
    if (status == cudaSuccess) {
      probe.name = properties.name;
      probe.compute_capability = 10 * properties.major + properties.minor;
      cudaFuncAttributes attributes;
      status = cudaFuncGetAttributes(&attributes, any_kernel);
    }
  }
  cudaGetLastError();  // or the next launch would report it
  switch (status) {
    case cudaSuccess:
      probe.state = GpuState::kUsable;
      break;
    case cudaErrorInsufficientDriver:
      probe.state = probe.driver_cuda_version == 0 ? GpuState::kNoDriver : GpuState::kOldDriver;
      break;
    case cudaErrorNoDevice:
      probe.state = GpuState::kNoGpu;
      break;
    case cudaErrorNoKernelImageForDevice:
    case cudaErrorInvalidDeviceFunction:
    case cudaErrorUnsupportedPtxVersion:
      probe.state = GpuState::kNoKernels;
      break;
    default:
      probe.state = GpuState::kFailed;
      probe.failure = cudaGetErrorString(status);
  }
  return probe;
}

}  // namespace

cudaStream_t stream() { return Context::get().stream(); }

namespace cuda_backend {

std::string problem() { return gpu_problem(probe()); }

void* allocate_zeroed(size_t bytes) {
  void* pointer = nullptr;
  const cudaError_t status = cudaMalloc(&pointer, bytes);
  if (status == cudaErrorMemoryAllocation) {
    cudaGetLastError();  // or the next launch would report it
    size_t free = 0, total = 0;
    cudaMemGetInfo(&free, &total);
    throw Error(gpu_memory_problem(bytes, free, total));
  }
  check_cuda(status, "allocation");
  check_cuda(cudaMemsetAsync(pointer, 0, bytes, stream()), "memset");
  return pointer;
}

// Kernels that were launched may still use the memory. Failures have been reported, or will be, by the calls
// that are not about to forget it.
void release(void* pointer) noexcept {
  if (!pointer) return;
  cudaDeviceSynchronize();
  cudaFree(pointer);
}

void* allocate_host(size_t bytes) {
  void* pointer = nullptr;
  check_cuda(cudaMallocHost(&pointer, bytes), "allocation of page-locked memory");
  return pointer;
}

void release_host(void* pointer) noexcept {
  if (!pointer) return;
  cudaDeviceSynchronize();
  cudaFreeHost(pointer);
}

void copy_to_device(void* to, const void* from, size_t bytes) {
  Context& context = Context::get();
  const std::lock_guard lock(context.turn());
  context.upload(to, from, bytes);
}

void copy_to_host(void* to, const void* from, size_t bytes) {
  Context& context = Context::get();
  const std::lock_guard lock(context.turn());
  context.download(to, from, bytes);
}

void start_copy_to_host(void* to, const void* from, size_t bytes) {
  check_cuda(cudaMemcpyAsync(to, from, bytes, cudaMemcpyDeviceToHost, stream()), "download");
}

void wait() { check_cuda(cudaStreamSynchronize(stream()), "wait"); }

int64_t compact_flags(const uint8_t* flags, int64_t count, int32_t* indices) {
  Context& context = Context::get();
  const std::lock_guard lock(context.turn());
  const thrust::counting_iterator<int32_t> all(0);
  const auto select = [&](void* scratch, size_t& bytes) {
    check_cuda(cub::DeviceSelect::Flagged(scratch, bytes, all, flags, indices, context.result(), count,
                                          context.stream()),
               "select");
  };
  size_t bytes = 0;
  select(nullptr, bytes);
  select(context.scratch(bytes), bytes);
  return context.downloaded_result();
}

int64_t exclusive_scan(const int32_t* counts, int64_t count, int32_t* offsets) {
  if (count == 0) return 0;
  Context& context = Context::get();
  const std::lock_guard lock(context.turn());
  const auto scan = [&](void* scratch, size_t& bytes) {
    check_cuda(cub::DeviceScan::ExclusiveSum(scratch, bytes, counts, offsets, count, context.stream()),
               "scan");
  };
  const auto sum = [&](void* scratch, size_t& bytes) {
    check_cuda(cub::DeviceReduce::Reduce(scratch, bytes, counts, context.result(), count,
                                         cuda::std::plus<int64_t>{}, int64_t{0}, context.stream()),
               "sum");
  };
  size_t scan_bytes = 0, sum_bytes = 0;
  scan(nullptr, scan_bytes);
  sum(nullptr, sum_bytes);
  scan(context.scratch(scan_bytes), scan_bytes);
  sum(context.scratch(sum_bytes), sum_bytes);
  return context.downloaded_result();
}

}  // namespace cuda_backend
}  // namespace kt::exec
