// Nodes and edges from logged poses and loop closures.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/report/odometry_graph.h"

#include <algorithm>

namespace kt {

PoseGraph odometry_graph(const Session& session) {
  PoseGraph graph;
  const StampedPose* previous = nullptr;
  std::vector<int64_t> ids;
  for (const StampedPose& pose : session.trajectory) {
    graph.nodes.push_back({pose.sequence, pose.T_odom_camera, previous == nullptr});
    ids.push_back(pose.sequence);
    if (previous != nullptr) {
      const Pose T_previous_current = previous->T_odom_camera.inverse(Eigen::Isometry) * pose.T_odom_camera;
      graph.edges.push_back({previous->sequence, pose.sequence, T_previous_current, pose.information});
    }
    previous = &pose;
  }
  std::sort(ids.begin(), ids.end());
  const auto has_node = [&ids](int64_t id) { return std::binary_search(ids.begin(), ids.end(), id); };
  for (const LoopClosure& loop : session.loop_closures) {
    if (!loop.accepted || !has_node(loop.from) || !has_node(loop.to)) continue;
    graph.edges.push_back({loop.from, loop.to, loop.T_from_to, loop.information});
  }
  return graph;
}

}  // namespace kt
