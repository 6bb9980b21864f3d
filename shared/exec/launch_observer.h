// Someone who watches what a device is given to do: tests find with it the first kernel whose results differ.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <typeinfo>

#include "shared/exec/device.h"

namespace kt::exec {

/// Called by the thread that calls the device; without one a launch costs one branch more.
class LaunchObserver {
 public:
  virtual ~LaunchObserver() = default;
  /// A zeroed buffer of `size` elements, not empty.
  virtual void on_allocated(const void* data, int64_t size, size_t element_bytes,
                            const std::type_info& element) = 0;
  /// Before the memory goes.
  virtual void on_released(const void* data) = 0;
  /// After a launch over `elements` elements; a GPU may still be at it. `kernel` is the mangled name of a
  /// functor, or one of "compact_flags", "exclusive_scan" and "upload".
  virtual void on_launched(const char* kernel, int64_t elements) = 0;
};

/// Tells the device's observer of a launch when its scope ends.
class ObservedLaunch {
 public:
  ObservedLaunch(const Device& device, const char* kernel, int64_t elements)
      : observer_(device.observer()), kernel_(kernel), elements_(elements) {}
  ~ObservedLaunch() {
    if (observer_) observer_->on_launched(kernel_, elements_);
  }
  ObservedLaunch(const ObservedLaunch&) = delete;
  ObservedLaunch& operator=(const ObservedLaunch&) = delete;

 private:
  LaunchObserver* observer_;
  const char* kernel_;
  int64_t elements_;
};

}  // namespace kt::exec
