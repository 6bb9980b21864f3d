// The system calls that a Video4Linux device is used through: the seam at which tests put a device of their
// own.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <poll.h>
#include <string>
#include <vector>

namespace kt {

/// As the calls of the same names: -1 and errno, or null for map, where they fail.
class V4l2System {
 public:
  virtual ~V4l2System() = default;
  virtual int open(const std::string& path) = 0;  ///< for reading and writing, never blocking
  virtual int close(int fd) = 0;
  virtual int ioctl(int fd, unsigned long request, void* argument) = 0;
  virtual void* map(int fd, size_t bytes, int64_t offset) = 0;  ///< shared, for reading and writing
  virtual void unmap(void* address, size_t bytes) = 0;
  virtual int poll(pollfd* files, size_t count, int timeout_ms) = 0;
  virtual int64_t monotonic_us() = 0;            ///< CLOCK_MONOTONIC
  virtual std::vector<std::string> nodes() = 0;  ///< "/dev/video0", ... in the order of their numbers
};

/// The kernel's own.
V4l2System& linux_v4l2();

}  // namespace kt
