// The frames of missions that have a place in the map.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <memory>
#include <span>

#include "onboard/source/frame_source.h"
#include "shared/types/stamped_pose.h"

namespace kt {

/// Where the frames of a mission come from, and which sequences the session gave them.
struct MissionFrames {
  std::unique_ptr<FrameSource> source;
  int64_t first_sequence = 0, end_sequence = 0;
};

/// Reads the sources to their end and calls take(frame, T_world_camera, index of the pose) for the frames
/// that have the stamp of a good pose, with its sequence; the sources may give other frames too. `poses` are
/// in world. Is told the share done.
void for_each_placed_frame(const Trajectory& poses, std::span<const MissionFrames> missions,
                           const std::function<void(const RgbdFrame&, const Pose&, size_t)>& take,
                           const std::function<void(double)>& progress);

}  // namespace kt
