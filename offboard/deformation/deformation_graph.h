// The deformation graph: nodes along the camera's path, each moving the space around it.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "shared/geometry/se3.h"
#include "shared/types/stamped_pose.h"

namespace kt {

/// How a map is bent into place. Letters in brackets are those of the paper.
struct DeformationConfig {
  double node_spacing_m = 0.4;     ///< a node stands this far from the last one
  double node_ahead_m = 1.5;       ///< nodes stand so far in front of the camera, where it looks; 0: in it
  int neighbours = 4;              ///< [k] nodes that move a vertex, and neighbours of a node; even, 2 to 8
  int look_back = 10;              ///< nodes among which those of a vertex are sought, more than neighbours
  double rotation_weight = 1;      ///< [w_rot]
  double regularity_weight = 10;   ///< [w_reg]
  double constraint_weight = 100;  ///< [w_conP]
  double camera_arm_m = 1.0;       ///< see camera_constraints
  double huber_m = 0.05;           ///< beyond it a surface constraint pulls with constant force
  int max_iterations = 10;
  double min_relative_decrease = 1e-5;  ///< of the energy; below it the solution has converged
  double max_stretch = 0.5;             ///< a solution that stretches an edge by more is rejected
};

/// Moves a point p_odom to R (p_odom - g) + g + t in world (the paper's eq. 3). R is a rotation before the
/// solution, nearly one after it.
struct DeformationNode {
  int64_t pose_sequence = 0;  ///< of the pose it was sampled at
  Eigen::Vector3d g_odom = Eigen::Vector3d::Zero();
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  Eigen::Vector3d t = Eigen::Vector3d::Zero();

  Eigen::Vector3d moved(const Eigen::Vector3d& p_odom) const { return R * (p_odom - g_odom) + g_odom + t; }
};

struct DeformationGraph {
  DeformationConfig config;
  std::vector<DeformationNode> nodes;     ///< ascending by pose_sequence
  std::vector<std::array<int, 2>> edges;  ///< {l, k} for each neighbour k of each node l, ascending

  /// Whether it leaves every point where it is.
  bool is_identity() const;
};

/// Whether a pose and its optimised twin are to be built on: tracked well, so that its frame was fused, and
/// both of them rigid and finite.
bool is_usable(const StampedPose& before, const Pose& after);

/// Samples nodes along the usable poses (Whelan et al. 2013, incremental sampling): the first, and each whose
/// node would stand farther than node_spacing_m from the last one taken. Nodes stand where the camera looks:
/// so a turn on the spot has nodes, and a vertex hangs on the poses from which it was seen, not on those at
/// which the camera later passed it by. Neighbours are those next in time, half before and
/// half after; towards the ends of the path the first or last neighbours + 1 nodes are joined among
/// themselves. Two passes of one place share no edge, so they are free to come together.
///
/// `before` (T_odom_camera) holds one segment, ascending by sequence; `after` (T_world_camera) has a pose for
/// each. Each node starts at the motion of its own pose, T_after * T_before^-1. Kintinuous starts at the
/// identity: its poses come while the map grows; here they are final, and what they say of rotation need not
/// be found again from positions. Poses that did not change give exact identities.
DeformationGraph build_deformation_graph(const Trajectory& before, std::span<const Pose> after,
                                         const DeformationConfig& config = {});

}  // namespace kt
