// Memory of both executors.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/exec/buffer.h"

#include <cstdint>
#include <cstring>
#include <string>
#include <sys/mman.h>
#include <unistd.h>

#include "shared/exec/cuda_backend.h"

namespace kt::exec {

void* allocate_zeroed(const Device& device, size_t bytes) {
  if (bytes == 0) return nullptr;
#if defined(KT_HAVE_CUDA)
  if (device.is_cuda()) return cuda_backend::allocate_zeroed(bytes);
#endif
  (void)device;
  // Anonymous pages are zero, page-aligned, and physical only once written: a large volume costs what it
  // holds.
  void* pointer =
      mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (pointer == MAP_FAILED) {
    throw Error("not enough memory for " + std::to_string(bytes >> 20) +
                " MiB: use a smaller volume (volume.resolution)");
  }
  return pointer;
}

void release(const Device& device, void* pointer, size_t bytes) noexcept {
  if (!pointer) return;
#if defined(KT_HAVE_CUDA)
  if (device.is_cuda()) return cuda_backend::release(pointer);
#endif
  (void)device;
  munmap(pointer, bytes);
}

void* allocate_host(const Device& device, size_t bytes) {
#if defined(KT_HAVE_CUDA)
  if (device.is_cuda() && bytes > 0) return cuda_backend::allocate_host(bytes);
#endif
  return allocate_zeroed(device, bytes);
}

void release_host(const Device& device, void* pointer, size_t bytes) noexcept {
#if defined(KT_HAVE_CUDA)
  if (device.is_cuda()) return cuda_backend::release_host(pointer);
#endif
  release(device, pointer, bytes);
}

void give_back_zeros(const Device& device, void* pointer, size_t bytes) {
  if (device.is_cuda()) return;
  const auto page = static_cast<uintptr_t>(sysconf(_SC_PAGESIZE));
  const auto address = reinterpret_cast<uintptr_t>(pointer);
  const uintptr_t first = (address + page - 1) / page * page, last = (address + bytes) / page * page;
  // Whole pages only; where the call fails the memory merely stays in use.
  if (first < last) madvise(reinterpret_cast<void*>(first), last - first, MADV_DONTNEED);
}

void copy_to_device(const Device& device, void* to, const void* from, size_t bytes) {
  if (bytes == 0) return;
#if defined(KT_HAVE_CUDA)
  if (device.is_cuda()) return cuda_backend::copy_to_device(to, from, bytes);
#endif
  (void)device;
  std::memcpy(to, from, bytes);
}

void copy_to_host(const Device& device, void* to, const void* from, size_t bytes) {
  if (bytes == 0) return;
#if defined(KT_HAVE_CUDA)
  if (device.is_cuda()) return cuda_backend::copy_to_host(to, from, bytes);
#endif
  (void)device;
  std::memcpy(to, from, bytes);
}

void start_copy_to_host(const Device& device, void* to, const void* from, size_t bytes) {
  if (bytes == 0) return;
#if defined(KT_HAVE_CUDA)
  if (device.is_cuda()) return cuda_backend::start_copy_to_host(to, from, bytes);
#endif
  (void)device;
  std::memcpy(to, from, bytes);
}

void wait(const Device& device) {
#if defined(KT_HAVE_CUDA)
  if (device.is_cuda()) cuda_backend::wait();
#endif
  (void)device;
}

}  // namespace kt::exec
