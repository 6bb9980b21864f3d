// What is given up first where a disk fills up.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstdint>
#include <type_traits>

#include "shared/types/keyframe.h"
#include "shared/types/motion_sample.h"
#include "shared/types/rgbd_frame.h"
#include "shared/types/storage_state.h"

namespace kt {

/// Where less than `reserve_bytes` are free, raw frames and motion samples are no longer stored; where less
/// than a quarter of it are, keyframes neither. Poses, slices, closures and status are tried as long as the
/// mission lasts. What was given up comes back where an eighth more than its limit is free. Once the disk
/// has refused an event the reserve is at least 16 MiB.
class StoragePolicy {
 public:
  explicit StoragePolicy(int64_t reserve_bytes) : reserve_bytes_(reserve_bytes) {}

  StorageLevel level() const { return level_; }

  void see_free_bytes(int64_t free_bytes) {
    if (level_ == StorageLevel::kFull) return;  // the next event that is taken tells more
    const StorageLevel now = level_for(free_bytes);
    level_ = now >= level_ ? now : level_for(free_bytes / 9 * 8);
  }
  void see_refusal() {
    constexpr int64_t kLeastAfterRefusal = int64_t{16} << 20;
    level_ = StorageLevel::kFull;
    reserve_bytes_ = std::max(reserve_bytes_, kLeastAfterRefusal);
  }
  void see_success() { level_ = std::min(level_, StorageLevel::kNoKeyframes); }

  /// Whether a message of type T is worth trying.
  template <typename T>
  bool wants() const {
    if constexpr (std::is_same_v<T, RgbdFrame> || std::is_same_v<T, MotionSample>) {
      return level_ < StorageLevel::kNoRawFrames;
    } else if constexpr (std::is_same_v<T, Keyframe>) {
      return level_ < StorageLevel::kNoKeyframes;
    } else {
      return true;
    }
  }

 private:
  StorageLevel level_for(int64_t free_bytes) const {
    return free_bytes < reserve_bytes_ / 4 ? StorageLevel::kNoKeyframes
           : free_bytes < reserve_bytes_   ? StorageLevel::kNoRawFrames
                                           : StorageLevel::kAll;
  }

  int64_t reserve_bytes_;
  StorageLevel level_ = StorageLevel::kAll;
};

}  // namespace kt
