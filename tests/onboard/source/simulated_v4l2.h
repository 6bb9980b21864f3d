// Video4Linux nodes behind the seam of system calls: formats, buffers, images, losses and unplugging as a
// test says.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "onboard/source/v4l2_system.h"

namespace kt::test {

/// Of formats, for those who do not know the requests: V4L2_PIX_FMT_...
extern const uint32_t kSimulatedZ16, kSimulatedRgb24;

/// What a node gives.
struct SimulatedFormat {
  uint32_t code = 0;  ///< V4L2_PIX_FMT_...
  int width = 0, height = 0;
  std::vector<int> rates_hz = {30};
  int padding = 0;  ///< bytes at the end of each row
};

struct SimulatedImage {
  std::vector<uint8_t> bytes;
  int64_t stamp_us = 0;
  uint32_t sequence = 0;
  bool is_damaged = false;
};

struct SimulatedNode {
  std::string card = "Simulated camera";
  bool captures = true, is_monotonic = true;
  std::vector<SimulatedFormat> formats;
  std::deque<SimulatedImage> images;  ///< not yet in a buffer
  int open_error = 0;                 ///< of the next calls of open
  bool is_unplugged = false;
  // What the program has done:
  const SimulatedFormat* format = nullptr;
  int rate_hz = 0;
  bool is_open = false, is_streaming = false;
  std::vector<std::unique_ptr<std::vector<uint8_t>>> buffers;
  std::deque<uint32_t> queued;
  int mapped = 0;
};

/// Time passes only where poll waits in vain, by its timeout.
class SimulatedV4l2 final : public V4l2System {
 public:
  SimulatedNode& node(const std::string& path) { return nodes_[path]; }
  /// Leaves the program's descriptors behind, dead, as the kernel does; the images are gone.
  void unplug();
  void plug();
  bool is_all_released() const;

  int open(const std::string& path) override;
  int close(int fd) override;
  int ioctl(int fd, unsigned long request, void* argument) override;
  void* map(int fd, size_t bytes, int64_t offset) override;
  void unmap(void* address, size_t bytes) override;
  int poll(pollfd* files, size_t count, int timeout_ms) override;
  int64_t monotonic_us() override { return now_us; }
  std::vector<std::string> nodes() override;

  std::function<void()> on_silence;  ///< where poll finds nothing
  int64_t now_us = 1'000'000;

 private:
  SimulatedNode* open_node(int fd);

  std::map<std::string, SimulatedNode> nodes_;
  std::map<int, std::string> open_;
  int next_fd_ = 100;
};

}  // namespace kt::test
