// A camera pose of the trajectory, and how far it can be trusted.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "shared/geometry/se3.h"

namespace kt {

enum class TrackingStatus : uint8_t {
  kGood = 0,       ///< pose measured, frame fused
  kUncertain = 1,  ///< pose estimated, frame not fused
  kLost = 2,       ///< pose repeated from the last good frame, frame not fused
};

/// "good", "uncertain" or "lost".
const char* to_string(TrackingStatus status);

/// A pose graph node with its odometry edge.
struct StampedPose {
  int64_t sequence = 0;  ///< of the frame
  int64_t timestamp_us = 0;
  Pose T_odom_camera = Pose::Identity();
  /// Sequence of the frame that this one was measured against, at which its edge starts: the last good one
  /// before it; of the first pose its own.
  int64_t from_sequence = 0;
  /// Information of that edge: inverse covariance of the left perturbation xi of T_from_current, [rotation
  /// (rad); translation (m)]. Zero for the first pose.
  Matrix6d information = Matrix6d::Zero();
  TrackingStatus status = TrackingStatus::kGood;
};

using Trajectory = std::vector<StampedPose>;

}  // namespace kt
