// The time of a live mission: a camera's stamps, whatever its clock does, as stamps that only go forward.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <optional>

namespace kt {

/// Stamps of the mission start at the wall clock's time of the first image and go on as the device's clock
/// does, not as the wall clock. Where the device's clock steps, or the camera comes back with another one,
/// the stamps go on by the time that passed here, as a steady clock has it.
class StampClock {
 public:
  /// What became of a stamp.
  struct Stamp {
    int64_t us = 0;           ///< of the mission
    bool is_stepped = false;  ///< the device's clock was set: it does not go on from the image before
  };

  /// `device_us` of an image of one stream, read when the steady clock showed `steady_us` and the wall
  /// clock `wall_us`.
  Stamp stamp(int stream, int64_t device_us, int64_t steady_us, int64_t wall_us);

  /// The camera was gone: its next image says nothing of the time in between.
  void interrupt();

 private:
  static constexpr int kStreams = 2;

  std::optional<int64_t> offset_us_;  // mission minus device
  std::array<std::optional<int64_t>, kStreams> last_device_us_;
  int64_t newest_us_ = 0;         // of the mission
  int64_t newest_steady_us_ = 0;  // when that was read
  bool has_begun_ = false;
};

}  // namespace kt
