// Nodes and edges from logged poses and loop closures.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/pose_graph/mission_graph.h"

#include <algorithm>
#include <map>
#include <utility>

namespace kt {
namespace {

// Of each segment the first good pose; what hangs on it is the graph, lost ones before it hang on nothing. A
// segment without one has its first pose.
std::map<int, int64_t> fixed_sequences(const Trajectory& poses) {
  std::map<int, int64_t> fixed;
  for (const StampedPose& pose : poses) {
    if (pose.status == TrackingStatus::kGood) fixed.try_emplace(pose.segment, pose.sequence);
  }
  for (const StampedPose& pose : poses) fixed.try_emplace(pose.segment, pose.sequence);
  return fixed;
}

}  // namespace

MissionGraph mission_graph(const Trajectory& poses, std::span<const LoopClosure> loop_closures) {
  MissionGraph mission;
  const auto find = [&poses](int64_t sequence) -> const StampedPose* {
    const auto found =
        std::lower_bound(poses.begin(), poses.end(), sequence,
                         [](const StampedPose& pose, int64_t wanted) { return pose.sequence < wanted; });
    return found != poses.end() && found->sequence == sequence ? &*found : nullptr;
  };
  const std::map<int, int64_t> fixed = fixed_sequences(poses);
  std::map<int, const StampedPose*> last;  // by segment
  for (const StampedPose& pose : poses) {
    mission.graph.nodes.push_back(
        {pose.sequence, pose.T_odom_camera, fixed.at(pose.segment) == pose.sequence});
    const StampedPose* before = std::exchange(last[pose.segment], &pose);
    if (!before) continue;  // it begins the segment
    const StampedPose* from = pose.from_sequence < pose.sequence ? find(pose.from_sequence) : nullptr;
    Matrix6d information = pose.information;
    if (!from || from->segment != pose.segment) {
      from = before;
      information /= static_cast<double>(pose.sequence - before->sequence + 1);
    }
    const Pose T_from_current = from->T_odom_camera.inverse(Eigen::Isometry) * pose.T_odom_camera;
    mission.graph.edges.push_back({from->sequence, pose.sequence, T_from_current, information});
  }
  for (size_t i = 0; i < loop_closures.size(); ++i) {
    const LoopClosure& loop = loop_closures[i];
    if (!loop.accepted() || !find(loop.from) || !find(loop.to)) continue;
    mission.loop_edges.push_back(mission.graph.edges.size());
    mission.loops.push_back(i);
    mission.graph.edges.push_back({loop.from, loop.to, loop.T_from_to, loop.information});
  }
  return mission;
}

}  // namespace kt
