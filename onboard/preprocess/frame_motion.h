// How the camera moves while the two images of a frame are taken.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "onboard/preprocess/preprocessor.h"
#include "shared/core/row_motion.h"
#include "shared/geometry/se3.h"

namespace kt {

/// The depth image and the colour image have stamps of their own, and a rolling shutter reads either row by
/// row (Ringaby and Forssén, ICCV 2011). A frame's pose is that of the depth camera at the middle row of the
/// depth image.
class FrameMotion {
 public:
  /// No motion.
  FrameMotion() = default;
  /// `velocity` of the depth camera in its own frame, [rad/s; m/s].
  FrameMotion(const FrameMaps& maps, const Vector6d& velocity);

  /// The depth camera at the middle row of the colour image, seen from where it is at that of the depth
  /// image.
  const Pose& T_depth_colour_time() const { return T_depth_colour_time_; }

  const Vector6d& velocity() const { return velocity_; }
  /// Whether all pixels of both images saw the same place, for the camera stood still or they were taken at
  /// once.
  bool is_still() const { return is_still_; }
  /// Of an image of the depth camera at any resolution.
  RowMotion depth_rows(const PinholeParams& camera) const;
  /// Of an image of the colour camera.
  RowMotion colour_rows(const PinholeParams& camera, const Pose& T_colour_depth) const;

 private:
  Pose T_depth_colour_time_ = Pose::Identity();
  Vector6d velocity_ = Vector6d::Zero();
  double readout_s_ = 0;
  bool is_still_ = true;
};

/// Of an image of `camera`, which moves with `velocity` in its own frame, [rad/s; m/s].
RowMotion row_motion(const Vector6d& velocity, double readout_s, const PinholeParams& camera);

}  // namespace kt
