// Where kernels run: CPU threads or one CUDA GPU.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>
#include <utility>

#include "shared/exec/thread_pool.h"

namespace kt::exec {

class LaunchObserver;

/// A value that every buffer and launch is given; copies share the threads.
class Device {
 public:
  /// One CPU thread.
  Device() : Device(cpu(1)) {}
  /// `threads` = 0 takes all cores. Throws kt::Error where threads lies outside [0, 1024].
  static Device cpu(int threads = 0);
  /// The first CUDA GPU. Throws kt::Error naming the remedy where this build or this machine has none.
  static Device cuda();
  /// "cpu", "cuda", or "auto": cuda where cuda_is_available(), else cpu. Throws kt::Error for any other name.
  static Device from_name(const std::string& name, int threads);

  /// The same device, whose buffers and launches `observer` is told of.
  Device observed_by(std::shared_ptr<LaunchObserver> observer) const;
  /// Null where nobody observes it.
  LaunchObserver* observer() const { return observer_.get(); }

  bool is_cuda() const { return is_cuda_; }
  /// "cpu" or "cuda".
  const char* name() const { return is_cuda_ ? "cuda" : "cpu"; }
  int threads() const { return is_cuda_ ? 1 : pool_->threads(); }
  /// The threads of a CPU device.
  ThreadPool& pool() const { return *pool_; }

 private:
  Device(bool is_cuda, std::shared_ptr<ThreadPool> pool) : is_cuda_(is_cuda), pool_(std::move(pool)) {}
  bool is_cuda_;
  std::shared_ptr<ThreadPool> pool_;  // null for cuda
  std::shared_ptr<LaunchObserver> observer_;
};

/// Whether this build has the CUDA executor and this machine a usable GPU; where not, `reason` says why.
bool cuda_is_available(std::string* reason = nullptr);

}  // namespace kt::exec
