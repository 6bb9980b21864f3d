// What a deformation has to reach: points of the odometry frame and where they belong in the world.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include "offboard/deformation/deformation_graph.h"
#include "shared/types/loop_closure.h"

namespace kt {

struct PointConstraint {
  Eigen::Vector3d p_odom = Eigen::Vector3d::Zero();
  int64_t pose_sequence = 0;  ///< of the frame that saw it
  Eigen::Vector3d p_world = Eigen::Vector3d::Zero();
  bool is_surface = false;  ///< measured, so it may be wrong: under Huber's loss
};

/// The view centre (node_ahead_m in front of the camera) of every usable pose, from before to after, and with
/// camera_arm_m above 0 the points so far from it along the camera's three axes. With both lengths 0 these
/// are the camera positions of the paper's E_conP (eq. 8). But positions of a straight path say nothing of
/// rotation about it, and those of a nearly straight one next to nothing; the points along the axes do.
std::vector<PointConstraint> camera_constraints(const Trajectory& before, std::span<const Pose> after,
                                                const DeformationConfig& config);

/// The inliers of `loops`, which are those that the optimiser kept: both sightings of each, to the point half
/// way between the places that the poses after give them. Where the poses fulfil the loop exactly this is
/// Kintinuous' surface constraint; else it closes the gap that they leave. Loops of a frame that is missing
/// or not usable and points that are not finite are left out.
std::vector<PointConstraint> surface_constraints(const Trajectory& before, std::span<const Pose> after,
                                                 std::span<const LoopClosure> loops);

}  // namespace kt
