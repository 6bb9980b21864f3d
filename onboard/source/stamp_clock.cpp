// Follows a device's clock and notices where it steps.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/source/stamp_clock.h"

#include <algorithm>

namespace kt {
namespace {

// Images are read late and in bursts; a clock that runs ahead of ours by more was set.
constexpr int64_t kLongestBurst_us = 2'000'000;

}  // namespace

StampClock::Stamp StampClock::stamp(int stream, int64_t device_us, int64_t steady_us, int64_t wall_us) {
  auto& last_device_us = last_device_us_.at(static_cast<size_t>(stream));
  const int64_t passed_us = std::max<int64_t>(steady_us - newest_steady_us_, 1);
  bool is_stepped = false;
  if (offset_us_) {
    const int64_t ahead_us = device_us + *offset_us_ - newest_us_;
    is_stepped = (last_device_us && device_us <= *last_device_us) || ahead_us < -kLongestBurst_us ||
                 ahead_us > passed_us + kLongestBurst_us;
  }
  if (!offset_us_ || is_stepped) {
    offset_us_ = (has_begun_ ? newest_us_ + passed_us : wall_us) - device_us;
    last_device_us_ = {};
  }
  last_device_us_.at(static_cast<size_t>(stream)) = device_us;
  const int64_t us = device_us + *offset_us_;
  if (!has_begun_ || us > newest_us_) newest_us_ = us, newest_steady_us_ = steady_us;
  has_begun_ = true;
  return {us, is_stepped};
}

void StampClock::interrupt() {
  offset_us_.reset();
  last_device_us_ = {};
}

}  // namespace kt
