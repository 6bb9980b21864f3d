// Nodes and edges from logged poses and loop closures.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/report/odometry_graph.h"

#include <algorithm>

namespace kt {

PoseGraph odometry_graph(const Trajectory& poses, std::span<const LoopClosure> loop_closures) {
  PoseGraph graph;
  const auto find = [&poses](int64_t sequence) -> const StampedPose* {
    const auto found =
        std::lower_bound(poses.begin(), poses.end(), sequence,
                         [](const StampedPose& pose, int64_t wanted) { return pose.sequence < wanted; });
    return found != poses.end() && found->sequence == sequence ? &*found : nullptr;
  };
  // What hangs on the first good pose is the graph; lost ones before it hang on nothing.
  const auto first_good = std::find_if(poses.begin(), poses.end(), [](const StampedPose& pose) {
    return pose.status == TrackingStatus::kGood;
  });
  const StampedPose* fixed = first_good != poses.end() ? &*first_good : poses.data();
  for (const StampedPose& pose : poses) {
    graph.nodes.push_back({pose.sequence, pose.T_odom_camera, &pose == fixed});
    if (pose.from_sequence >= pose.sequence) continue;  // it begins the segment
    const StampedPose* from = find(pose.from_sequence);
    if (!from) continue;
    const Pose T_from_current = from->T_odom_camera.inverse(Eigen::Isometry) * pose.T_odom_camera;
    graph.edges.push_back({from->sequence, pose.sequence, T_from_current, pose.information});
  }
  for (const LoopClosure& loop : loop_closures) {
    if (!loop.accepted() || !find(loop.from) || !find(loop.to)) continue;
    graph.edges.push_back({loop.from, loop.to, loop.T_from_to, loop.information});
  }
  return graph;
}

}  // namespace kt
