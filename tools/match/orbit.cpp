// Free views of a synthetic world, with the flaws of its sensors.
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/match/orbit.h"

namespace kt {

Pose orbited(const Pose& T_world_camera, double ahead_m, double angle_rad) {
  const Eigen::Vector3d pivot = T_world_camera * Eigen::Vector3d(0, 0, ahead_m);
  const Pose turn(Eigen::AngleAxisd(angle_rad, Eigen::Vector3d::UnitZ()));
  return orthonormalised(Eigen::Translation3d(pivot) * turn * Eigen::Translation3d(-pivot) * T_world_camera);
}

RgbdFrame render_at(const SyntheticMission& mission, const Pose& T_world_camera, int64_t number) {
  const Calibration& calibration = mission.calibration();
  const View view = Renderer(mission.scene(), calibration.depth).render(T_world_camera);
  RgbdFrame frame;
  frame.sequence = number;
  frame.timestamp_us = frame.colour_timestamp_us = 1'000'000 + 33'333 * number;
  frame.depth =
      flawed_depth(view, mission.scene(), calibration.depth_unit_m, DepthFlaws{}, mission.seed(), number, 1);
  frame.colour = expose(view.radiance, {1, 1, 1}, true, mission.seed(), number, 1);
  return frame;
}

bool stands_free(const SyntheticMission& mission, const Pose& T_world_camera) {
  Camera camera = mission.calibration().depth;
  constexpr int kDivisor = 16;
  camera.width /= kDivisor;
  camera.height /= kDivisor;
  camera.fx /= kDivisor;
  camera.fy /= kDivisor;
  camera.cx = (camera.cx + 0.5) / kDivisor - 0.5;
  camera.cy = (camera.cy + 0.5) / kDivisor - 0.5;
  const View view = Renderer(mission.scene(), camera).render(T_world_camera, false);
  int64_t near = 0;
  for (const double z_m : view.z_m.pixels()) near += z_m < DepthFlaws{}.nearest_m;
  return near * 50 < view.z_m.pixel_count();
}

}  // namespace kt
