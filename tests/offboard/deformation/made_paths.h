// Camera paths in closed form and vertices seen from them, for the tests of deformation.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <limits>
#include <vector>

#include "shared/core/rng.h"
#include "shared/types/slice_vertex.h"
#include "shared/types/stamped_pose.h"

namespace kt::test {

inline constexpr double kFrameStep_m = 0.02;
inline constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

inline Pose made_pose(const Eigen::Vector3d& rotation_vector, const Eigen::Vector3d& translation) {
  Pose T = Pose::Identity();
  T.linear() = exp_so3(rotation_vector);
  T.translation() = translation;
  return T;
}

inline StampedPose stamped(int64_t sequence, const Pose& T_odom_camera) {
  StampedPose pose;
  pose.sequence = sequence;
  pose.T_odom_camera = T_odom_camera;
  return pose;
}

/// Straight on along z.
inline std::vector<Pose> straight_path(int frames) {
  std::vector<Pose> poses;
  for (int i = 0; i < frames; ++i) poses.push_back(made_pose({0, 0, 0}, {0, 0, kFrameStep_m * i}));
  return poses;
}

/// The same path as odometry sees it that drifts by `yaw_rad_per_m`: an arc of a circle.
inline std::vector<Pose> arc_path(int frames, double yaw_rad_per_m) {
  std::vector<Pose> poses;
  for (int i = 0; i < frames; ++i) {
    const double yaw = yaw_rad_per_m * kFrameStep_m * i;
    poses.push_back(
        made_pose({0, yaw, 0}, {(1 - std::cos(yaw)) / yaw_rad_per_m, 0, std::sin(yaw) / yaw_rad_per_m}));
  }
  return poses;
}

/// Frames 0, 1, 2, ... at these poses.
inline Trajectory trajectory_of(const std::vector<Pose>& poses) {
  Trajectory trajectory;
  for (const Pose& pose : poses) trajectory.push_back(stamped(static_cast<int64_t>(trajectory.size()), pose));
  return trajectory;
}

inline SliceVertex vertex_at(const Eigen::Vector3d& p_odom, int64_t pose_sequence) {
  SliceVertex vertex;
  vertex.p_odom = to_vec3f(p_odom);
  vertex.n_odom = {0, 0, -1};
  vertex.pose_sequence = static_cast<uint32_t>(pose_sequence);
  return vertex;
}

/// Uniform in [-1, 1]^3.
inline Eigen::Vector3d random_point(uint64_t seed, int64_t i) {
  const auto value = [&](uint64_t axis) {
    return 2 * random_uniform(seed, axis, static_cast<uint64_t>(i)) - 1;
  };
  return {value(0), value(1), value(2)};
}

}  // namespace kt::test
