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
  double depth_unit_m = 0.001;             ///< metres per unit of the depth image
  uint16_t invalid_depth = 0;  ///< a raw value that means "none" besides 0 (65535 in 7-Scenes); 0 = no other
  /// Of a rolling shutter: from the first row of an image to the last, of both cameras; 0 = global shutter,
  /// less = from the last row to the first.
  double readout_s = 0;
  double stamp_delay_s = 0;  ///< an image is stamped so long after its middle row was taken

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
