// Sampling of nodes and their edges.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/deformation/deformation_graph.h"

#include <algorithm>

#include "offboard/deformation/vertex_blend.h"
#include "shared/core/check.h"

namespace kt {
namespace {

void check(const DeformationConfig& config) {
  KT_CHECK(config.node_spacing_m > 0, "nodes need a distance");
  KT_CHECK(config.neighbours >= 2 && config.neighbours <= kMaxBlendNodes && config.neighbours % 2 == 0,
           "neighbours stand in pairs");
  KT_CHECK(config.look_back > config.neighbours, "look_back must hold more than the neighbours");
}

DeformationNode node_at(const StampedPose& before, const Pose& after, const Eigen::Vector3d& g_odom) {
  DeformationNode node;
  node.pose_sequence = before.sequence;
  node.g_odom = g_odom;
  if (before.T_odom_camera.matrix() == after.matrix()) return node;
  const Pose T_world_odom = after * before.T_odom_camera.inverse(Eigen::Isometry);
  node.R = T_world_odom.linear();
  node.t = T_world_odom * g_odom - g_odom;
  return node;
}

// Each node with the others of the block of neighbours + 1 nodes around it, as far as there are so many.
std::vector<std::array<int, 2>> temporal_edges(int nodes, int neighbours) {
  std::vector<std::array<int, 2>> edges;
  const int block = std::min(nodes, neighbours + 1);
  for (int l = 0; l < nodes; ++l) {
    const int begin = std::clamp(l - neighbours / 2, 0, nodes - block);
    for (int k = begin; k < begin + block; ++k) {
      if (k != l) edges.push_back({l, k});
    }
  }
  return edges;
}

}  // namespace

bool DeformationGraph::is_identity() const {
  return std::all_of(nodes.begin(), nodes.end(), [](const DeformationNode& node) {
    return node.R == Eigen::Matrix3d::Identity() && node.t == Eigen::Vector3d::Zero();
  });
}

bool is_usable(const StampedPose& before, const Pose& after) {
  return before.status == TrackingStatus::kGood && is_valid_pose(before.T_odom_camera) &&
         is_valid_pose(after);
}

DeformationGraph build_deformation_graph(const Trajectory& before, std::span<const Pose> after,
                                         const DeformationConfig& config) {
  check(config);
  KT_CHECK(before.size() == after.size(), "a pose after for each pose before");
  DeformationGraph graph;
  graph.config = config;
  for (size_t i = 0; i < before.size(); ++i) {
    KT_CHECK(i == 0 || before[i - 1].sequence < before[i].sequence, "poses ascend by sequence");
    if (!is_usable(before[i], after[i])) continue;
    const Eigen::Vector3d g_odom = before[i].T_odom_camera * Eigen::Vector3d(0, 0, config.node_ahead_m);
    if (graph.nodes.empty() || (g_odom - graph.nodes.back().g_odom).norm() > config.node_spacing_m)
      graph.nodes.push_back(node_at(before[i], after[i], g_odom));
  }
  graph.edges = temporal_edges(static_cast<int>(graph.nodes.size()), config.neighbours);
  return graph;
}

}  // namespace kt
