// Constraints from poses and from the inliers of loop closures.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/deformation/constraints.h"

#include <algorithm>

#include "shared/core/check.h"

namespace kt {
namespace {

// Index of the usable pose of this frame, or none: before.size().
size_t find(const Trajectory& before, std::span<const Pose> after, int64_t sequence) {
  const auto found =
      std::lower_bound(before.begin(), before.end(), sequence,
                       [](const StampedPose& pose, int64_t wanted) { return pose.sequence < wanted; });
  const auto index = static_cast<size_t>(found - before.begin());
  if (index == before.size() || found->sequence != sequence || !is_usable(*found, after[index]))
    return before.size();
  return index;
}

}  // namespace

std::vector<PointConstraint> camera_constraints(const Trajectory& before, std::span<const Pose> after,
                                                const DeformationConfig& config) {
  KT_CHECK(before.size() == after.size(), "a pose after for each pose before");
  std::vector<PointConstraint> constraints;
  for (size_t i = 0; i < before.size(); ++i) {
    if (!is_usable(before[i], after[i])) continue;
    const auto add = [&](const Eigen::Vector3d& p_camera) {
      constraints.push_back(
          {before[i].T_odom_camera * p_camera, before[i].sequence, after[i] * p_camera, false});
    };
    const Eigen::Vector3d centre(0, 0, config.node_ahead_m);
    add(centre);
    if (config.camera_arm_m <= 0) continue;
    for (int axis = 0; axis < 3; ++axis) add(centre + config.camera_arm_m * Eigen::Vector3d::Unit(axis));
  }
  return constraints;
}

std::vector<PointConstraint> surface_constraints(const Trajectory& before, std::span<const Pose> after,
                                                 std::span<const LoopClosure> loops) {
  KT_CHECK(before.size() == after.size(), "a pose after for each pose before");
  std::vector<PointConstraint> constraints;
  for (const LoopClosure& loop : loops) {
    const size_t from = find(before, after, loop.from), to = find(before, after, loop.to);
    if (from == before.size() || to == before.size()) continue;
    for (size_t i = 0; i < std::min(loop.p_from.size(), loop.p_to.size()); ++i) {
      const Eigen::Vector3d p_from = to_eigen(loop.p_from[i]), p_to = to_eigen(loop.p_to[i]);
      if (!p_from.allFinite() || !p_to.allFinite()) continue;
      const Eigen::Vector3d p_world = (after[from] * p_from + after[to] * p_to) / 2;
      constraints.push_back({before[from].T_odom_camera * p_from, loop.from, p_world, true});
      constraints.push_back({before[to].T_odom_camera * p_to, loop.to, p_world, true});
    }
  }
  return constraints;
}

}  // namespace kt
