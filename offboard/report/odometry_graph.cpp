// Nodes and edges from logged poses and loop closures.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/report/odometry_graph.h"

#include <algorithm>

namespace kt {

PoseGraph odometry_graph(const Session& session) {
  PoseGraph graph;
  const Trajectory& poses = session.trajectory;  // ascends by sequence
  const auto find = [&poses](int64_t sequence) -> const StampedPose* {
    const auto found =
        std::lower_bound(poses.begin(), poses.end(), sequence,
                         [](const StampedPose& pose, int64_t wanted) { return pose.sequence < wanted; });
    return found != poses.end() && found->sequence == sequence ? &*found : nullptr;
  };
  for (size_t i = 0; i < poses.size(); ++i) {
    const StampedPose& pose = poses[i];
    graph.nodes.push_back({pose.sequence, pose.T_odom_camera, i == 0});
    if (i == 0) continue;
    const StampedPose* measured_against =
        pose.from_sequence < pose.sequence ? find(pose.from_sequence) : nullptr;
    const StampedPose& from = measured_against ? *measured_against : poses[i - 1];
    const Pose T_from_current = from.T_odom_camera.inverse(Eigen::Isometry) * pose.T_odom_camera;
    graph.edges.push_back({from.sequence, pose.sequence, T_from_current, pose.information});
  }
  for (const LoopClosure& loop : session.loop_closures) {
    if (!loop.accepted || !find(loop.from) || !find(loop.to)) continue;
    graph.edges.push_back({loop.from, loop.to, loop.T_from_to, loop.information});
  }
  return graph;
}

}  // namespace kt
