// What of a mission still goes into its log, and what has not gone there, where the disk runs low.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

namespace kt {

/// In the order in which a disk that fills up takes things away.
enum class StorageLevel : int8_t {
  kAll,          ///< everything is stored
  kNoRawFrames,  ///< raw frames and motion samples are not
  kNoKeyframes,  ///< nor are keyframes: poses, slices, closures and status alone
  kFull,         ///< the disk refused the last event
};
inline constexpr int kStorageLevels = 4;

/// For people.
constexpr const char* to_string(StorageLevel level) {
  constexpr const char* kNames[kStorageLevels] = {"all is stored", "no raw frames are stored any more",
                                                  "no raw frames and no keyframes are stored any more",
                                                  "the disk is full"};
  return kNames[static_cast<int>(level)];
}

struct StorageState {
  StorageLevel level = StorageLevel::kAll;
  // Messages that were not stored, so far:
  int64_t raw_frames = 0, motion_samples = 0, keyframes = 0, slices = 0, poses = 0, others = 0;

  int64_t not_stored() const { return raw_frames + motion_samples + keyframes + slices + poses + others; }
};

}  // namespace kt
