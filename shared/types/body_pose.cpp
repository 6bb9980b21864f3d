// From camera to body.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/types/body_pose.h"

#include <cmath>

namespace kt {

BodyPose body_pose(const StampedPose& pose, const StampedPose* before, const Calibration& calibration) {
  const Pose& T_body_camera = calibration.T_body_camera;
  BodyPose body{.sequence = pose.sequence,
                .timestamp_us = pose.timestamp_us - std::llround(1e6 * calibration.stamp_delay_s),
                .T_odom_body = pose.T_odom_camera * T_body_camera.inverse(Eigen::Isometry),
                .segment = pose.segment,
                .status = pose.status};
  if (before) {
    if (const auto velocity = velocity_between(*before, pose))
      body.velocity = adjoint(T_body_camera) * *velocity;
  }
  return body;
}

}  // namespace kt
