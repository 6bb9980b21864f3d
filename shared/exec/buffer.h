// Arrays on the device a kernel runs on.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <type_traits>
#include <vector>

#include "shared/core/check.h"
#include "shared/exec/device.h"
#include "shared/exec/launch_observer.h"

namespace kt::exec {

/// Zeroed memory on `device`; on a CPU large blocks cost physical memory only where they are written. Throws
/// kt::Error where there is not enough.
void* allocate_zeroed(const Device& device, size_t bytes);
void release(const Device& device, void* pointer, size_t bytes) noexcept;
/// Returns the memory behind a range of zeros to the system where the device can do without it; it still
/// reads as zeros.
void give_back_zeros(const Device& device, void* pointer, size_t bytes);
void copy_to_device(const Device& device, void* to, const void* from, size_t bytes);
void copy_to_host(const Device& device, void* to, const void* from, size_t bytes);

/// Host memory that a device can copy to while the host goes on; page-locked for a GPU, which is scarce.
void* allocate_host(const Device& device, size_t bytes);
void release_host(const Device& device, void* pointer, size_t bytes) noexcept;
/// Into memory of allocate_host, whose bytes are there after wait().
void start_copy_to_host(const Device& device, void* to, const void* from, size_t bytes);
/// Until the device has done what it was given.
void wait(const Device& device);

/// A fixed number of elements in memory of allocate_host, without values at first; moves, does not copy.
template <typename T>
class HostBuffer {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  HostBuffer() = default;
  HostBuffer(const Device& device, int64_t size)
      : size_(size),
        data_(static_cast<T*>(allocate_host(device, static_cast<size_t>(size) * sizeof(T))),
              Release{device, static_cast<size_t>(size) * sizeof(T)}) {}

  int64_t size() const { return data_ ? size_ : 0; }
  T* data() { return data_.get(); }
  const T* data() const { return data_.get(); }

 private:
  struct Release {
    Device device;
    size_t bytes = 0;
    void operator()(T* pointer) const { release_host(device, pointer, bytes); }
  };
  int64_t size_ = 0;
  std::unique_ptr<T, Release> data_;
};

/// A fixed number of elements of a plain type, zeroed at first; moves, does not copy.
template <typename T>
class Buffer {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  Buffer() = default;
  Buffer(const Device& device, int64_t size)
      : device_(device),
        size_(size),
        data_(static_cast<T*>(allocate_zeroed(device, bytes_of(size))), Release{device, bytes_of(size)}) {
    if (device.observer() && data_) device.observer()->on_allocated(data(), size, sizeof(T), typeid(T));
  }

  int64_t size() const { return data_ ? size_ : 0; }
  T* data() { return data_.get(); }
  const T* data() const { return data_.get(); }

  /// For elements [first, first + count), which must be zero.
  void give_back_zeros(int64_t first, int64_t count) {
    exec::give_back_zeros(device_, data() + first, bytes_of(count));
  }
  void upload(std::span<const T> values) {
    const ObservedLaunch observed(device_, "upload", static_cast<int64_t>(values.size()));
    KT_CHECK(static_cast<int64_t>(values.size()) <= size_);
    copy_to_device(device_, data(), values.data(), values.size_bytes());
  }
  /// Copies the first values.size() elements to the host; waits for the kernels before it.
  void download(std::span<T> values) const {
    KT_CHECK(static_cast<int64_t>(values.size()) <= size_);
    copy_to_host(device_, values.data(), data(), values.size_bytes());
  }
  /// The same without waiting: the values are there after exec::wait().
  void start_download(int64_t count, HostBuffer<T>& values) const {
    KT_CHECK(count <= size_ && count <= values.size());
    start_copy_to_host(device_, values.data(), data(), bytes_of(count));
  }
  std::vector<T> downloaded() const { return downloaded(size_); }
  std::vector<T> downloaded(int64_t count) const {
    std::vector<T> values(static_cast<size_t>(count));
    download(values);
    return values;
  }

 private:
  static size_t bytes_of(int64_t size) { return static_cast<size_t>(size) * sizeof(T); }
  struct Release {
    Device device;
    size_t bytes = 0;
    void operator()(T* pointer) const {
      if (device.observer()) device.observer()->on_released(pointer);
      release(device, pointer, bytes);
    }
  };
  Device device_;
  int64_t size_ = 0;
  std::unique_ptr<T, Release> data_;
};

}  // namespace kt::exec
