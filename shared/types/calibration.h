// The cameras of a rig: intrinsics, how they stand to each other, and what one unit of depth means.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "shared/geometry/camera.h"
#include "shared/geometry/se3.h"

namespace kt {

struct Calibration {
  std::string name;  ///< for people: "tum-fr1", "front camera"
  Camera depth;      ///< undistorted before use
  Camera colour;
  Pose T_colour_depth = Pose::Identity();  ///< maps points of the depth camera to the colour camera (m)
  /// Maps points of the depth camera to the body of the robot that carries it, of whatever convention, as x
  /// forward, y left, z up of ROS REP 103. The odom frame is where the body was first: the identity makes
  /// that the camera.
  Pose T_body_camera = Pose::Identity();
  double depth_unit_m = 0.001;  ///< metres per unit of the depth image
  uint16_t invalid_depth = 0;   ///< a raw value that means "none" besides 0 (65535 in 7-Scenes); 0 = no other
  /// Of a rolling shutter: from the first row of an image to the last, of both cameras; 0 = global shutter,
  /// less = from the last row to the first.
  double readout_s = 0;
  double stamp_delay_s = 0;  ///< an image is stamped so long after its middle row was taken
  /// A colour image was taken so much later than its stamp says, if that of the depth image is right.
  double colour_delay_s = 0;

  /// Whether colour pixel (u, v) looks along depth pixel (u, v): same intrinsics and no offset.
  bool is_registered() const;

  /// Whether both see alike; names do not matter.
  bool is_equal_to(const Calibration& other) const;

  /// Empty where the calibration makes sense, else the first thing wrong with it.
  std::string problem() const;
  /// The part of it that asks only whether each number is in its range: what a log may hold.
  std::string range_problem() const;
};

}  // namespace kt
