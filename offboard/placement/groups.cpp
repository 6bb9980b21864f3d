// Sorts segments into groups.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/placement/groups.h"

#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "shared/core/check.h"

namespace kt {

int64_t Group::good_frames() const {
  int64_t good = 0;
  for (const Segment& segment : segments) good += segment.good_frames();
  return good;
}

Trajectory Group::trajectory() const {
  Trajectory poses;
  for (size_t s = 0; s < segments.size(); ++s) {
    for (size_t i = 0; i < segments[s].trajectory.size(); ++i) {
      poses.push_back(segments[s].trajectory[i]);
      poses.back().T_odom_camera = T_world_camera[s][i];
    }
  }
  std::sort(poses.begin(), poses.end(),
            [](const StampedPose& a, const StampedPose& b) { return a.sequence < b.sequence; });
  return poses;
}

std::vector<Group> take_groups(Session& session, const PlacedMission& placed) {
  struct Placed {
    Pose T_world_camera;
    int group;
  };
  std::map<int64_t, Placed> by_sequence;
  for (size_t i = 0; i < session.trajectory.size(); ++i)
    by_sequence.emplace(session.trajectory[i].sequence, Placed{placed.T_world_camera[i], placed.group[i]});
  std::map<int, size_t> place;  // in the list, by number of the group
  std::vector<Group> groups;
  for (Segment& segment : take_segments(session)) {
    std::vector<Pose> T_world_camera;
    for (const StampedPose& pose : segment.trajectory)
      T_world_camera.push_back(by_sequence.at(pose.sequence).T_world_camera);
    size_t at = groups.size();
    if (!segment.trajectory.empty())
      at = place.emplace(by_sequence.at(segment.trajectory.front().sequence).group, at).first->second;
    if (at == groups.size()) groups.emplace_back();
    groups[at].segments.push_back(std::move(segment));
    groups[at].T_world_camera.push_back(std::move(T_world_camera));
  }
  return groups;
}

size_t main_group(std::span<const Group> groups) {
  KT_CHECK(!groups.empty());
  const auto key = [](const Group& group) {
    const bool has_poses = std::any_of(group.segments.begin(), group.segments.end(),
                                       [](const Segment& segment) { return !segment.trajectory.empty(); });
    return std::pair(group.good_frames(), has_poses);
  };
  const auto main = std::max_element(groups.begin(), groups.end(),
                                     [&key](const Group& a, const Group& b) { return key(a) < key(b); });
  return static_cast<size_t>(main - groups.begin());
}

PoseGraph graph_of(const Group& group, const PlacedMission& placed) {
  PoseGraph graph;
  std::set<int64_t> ids;
  bool has_fixed = false;
  const Trajectory poses = group.trajectory();
  for (const StampedPose& pose : poses) ids.insert(pose.sequence);
  std::map<int64_t, bool> fixed;
  for (const PoseGraph::Node& node : placed.measured.graph.nodes) {
    if (ids.contains(node.id))
      fixed[node.id] = node.is_fixed && !std::exchange(has_fixed, has_fixed || node.is_fixed);
  }
  for (const StampedPose& pose : poses)
    graph.nodes.push_back({pose.sequence, pose.T_odom_camera, fixed.at(pose.sequence)});
  for (size_t e = 0; e < placed.measured.graph.edges.size(); ++e) {
    const PoseGraph::Edge& edge = placed.measured.graph.edges[e];
    const bool is_believed = !placed.is_optimised() || placed.solution.edges[e].weight > 0;
    if (is_believed && ids.contains(edge.from)) graph.edges.push_back(edge);
  }
  return graph;
}

}  // namespace kt
