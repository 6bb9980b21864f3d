// The frames of missions that have a place in the map.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <memory>
#include <span>

#include "offboard/placement/groups.h"
#include "onboard/source/frame_source.h"

namespace kt {

/// Where the frames of a mission come from, and which sequences the session gave them.
struct MissionFrames {
  std::unique_ptr<FrameSource> source;
  int64_t first_sequence = 0, end_sequence = 0;
};

/// Reads the sources to their end and calls take(frame, pose) for the frames that have the stamp of a good
/// pose of the group, with its sequence; the sources may give other frames too. Is told the share done.
void for_each_placed_frame(const Group& group, std::span<const MissionFrames> missions,
                           const std::function<void(const RgbdFrame&, const StampedPose&)>& take,
                           const std::function<void(double)>& progress);

}  // namespace kt
