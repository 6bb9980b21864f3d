// Where the robot's body is.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "shared/types/calibration.h"
#include "shared/types/stamped_pose.h"

namespace kt {

/// What a StampedPose says of the body that carries the camera.
struct BodyPose {
  int64_t sequence = 0;      ///< of the frame
  int64_t timestamp_us = 0;  ///< when the body was there: Calibration::stamp_delay_s before the frame's stamp
  Pose T_odom_body = Pose::Identity();
  /// Mean since the pose before it, of the body in its own frame, [rad/s; m/s]; zero where nothing is known.
  Vector6d velocity = Vector6d::Zero();
  int segment = 0;
  TrackingStatus status = TrackingStatus::kGood;
};

/// `before`: the pose before it, or null.
BodyPose body_pose(const StampedPose& pose, const StampedPose* before, const Calibration& calibration);

}  // namespace kt
