// Missions whose odometry drifts by a known law: the surface as odometry placed it, and where it truly is.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "shared/types/loop_closure.h"
#include "shared/types/slice_vertex.h"
#include "shared/types/stamped_pose.h"

namespace kt::bench {

enum class BentPath {
  kRing,      ///< 1 1/4 times around a circle of 4 m radius: the last quarter sees what the first saw
  kCorridor,  ///< 30 m straight on, walking: the camera sways by 1 cm
  kTurns,     ///< three legs of 3 m, a turn on the spot by 360 degrees after each
};

struct BentMissionOptions {
  BentPath path = BentPath::kRing;
  double yaw_drift_rad_per_m = 0.01;    ///< about the camera's vertical
  double roll_drift_rad_per_m = 0.005;  ///< about its optical axis
  double scale_drift = 0.01;            ///< of translation and of turns
  double pose_sigma_m = 0.003;          ///< of the optimised positions, changing along a second
  double pose_sigma_rad = 0.001;        ///< of their rotations, likewise
  double point_sigma_m = 0.005;         ///< of the points of loop closures
};

struct BentMission {
  Trajectory before;                  ///< as odometry would have it, 2 cm or 1.5 degrees per frame at 30 Hz
  std::vector<Pose> truth;            ///< T_world_camera; world is the first camera
  std::vector<Pose> after;            ///< the same with the noise of an optimiser
  std::vector<SliceVertex> vertices;  ///< p_odom: mean of where the frames that saw it in one go placed it
  std::vector<Eigen::Vector3d> true_points;  ///< in world, of the vertices
  std::vector<LoopClosure> loops;  ///< half a second apart, between passes 10 s or more apart, no outliers
};

/// Every number depends on the options alone.
BentMission make_bent_mission(const BentMissionOptions& options);

}  // namespace kt::bench
