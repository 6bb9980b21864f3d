// What another sensor of the robot says about the camera's motion: wheel odometry, an inertial unit.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "shared/geometry/se3.h"

namespace kt {

/// One sample; the samples of a mission are of one kind.
struct MotionSample {
  enum class Kind : uint8_t {
    kPose = 0,      ///< of a stream of poses, in a frame that may drift
    kVelocity = 1,  ///< holds until the next sample
  };

  /// Whose motion it is.
  enum class Of : uint8_t {
    kCamera = 0,  ///< the depth camera's
    kBody = 1,    ///< the robot's body's (Calibration::T_body_camera)
  };

  int64_t sequence = 0;      ///< counts the samples, from 0
  int64_t timestamp_us = 0;  ///< sensor clock of the frames
  Kind kind = Kind::kPose;
  Of of = Of::kCamera;
  Pose T_prior = Pose::Identity();       ///< of kPose: in the frame of the stream
  Vector6d velocity = Vector6d::Zero();  ///< of kVelocity: in its own frame (rad/s; m/s)
  double rotation_sigma = 0;     ///< growth of its error (rad per square root of a second); 0 = not measured
  double translation_sigma = 0;  ///< the same of the translation (m per square root of a second)

  /// Whether it says anything of the camera's motion. A pose without rotation does not: its translations
  /// stand in a frame of which the camera's orientation is unknown.
  bool measures_motion() const {
    return rotation_sigma > 0 || (kind == Kind::kVelocity && translation_sigma > 0);
  }
};

/// The same of the depth camera.
MotionSample of_camera(const MotionSample& sample, const Pose& T_body_camera);

}  // namespace kt
