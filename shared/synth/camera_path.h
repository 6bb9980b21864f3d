// A smooth camera path through way points, starting and ending at rest.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "shared/geometry/se3.h"

namespace kt {

/// Where the camera is and what it looks at, in the world (m, z up). Straight up and down are not allowed.
struct WayPoint {
  Eigen::Vector3d p_world;
  Eigen::Vector3d look_at_world;
};

struct PathPace {
  double speed_mps = 0.5;       ///< travelling speed between way points
  double turn_rate_rps = 0.6;   ///< turning rate (rad/s); each leg takes the longer of the two times
  double knot_spacing_s = 0.4;  ///< also how far corners are rounded off
  double sway_m = 0.008;        ///< unsteadiness of the hand, and the same in rad for the viewing direction
  uint64_t seed = 0;
};

/// A uniform cubic B-spline over positions, viewing directions and up vectors: twice continuously
/// differentiable. Its speed never exceeds that of its control polygon. Free of trigonometry, so that every
/// machine makes the same path.
class CameraPath {
 public:
  CameraPath(const std::vector<WayPoint>& way_points, const PathPace& pace);

  double duration_s() const;
  /// T_world_camera (x right, y down, z forward) at `t_s`, clamped to [0, duration].
  Pose at(double t_s) const;

 private:
  struct Knot {
    Eigen::Vector3d p, forward, up;
  };
  std::vector<Knot> knots_;
  double spacing_s_;
};

}  // namespace kt
