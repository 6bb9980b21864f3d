// Exact depth images of a wall, seen squarely: overlaps known in closed form.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "tools/eval/view_overlap.h"

namespace kt {

/// 160 x 120 pixels at a quarter of its resolution, with which it sees 2.56 m x 1.92 m of a wall 2 m away.
inline Calibration wall_calibration() {
  Calibration calibration;
  calibration.depth = {640, 480, 500, 500, 319.5, 239.5, {}};
  calibration.colour = calibration.depth;
  return calibration;
}

/// Without rotation, `x` m along a wall that lies in the plane z = 2 m, and `z` m towards it.
inline Pose facing_wall(double x, double z = 0) {
  Pose T = Pose::Identity();
  T.translation() = Eigen::Vector3d(x, 0, z);
  return T;
}

/// What such a camera sees.
inline Image<uint16_t> wall_depth(double z = 0) { return {160, 120, static_cast<uint16_t>(2000 - 1000 * z)}; }

}  // namespace kt
