// Sorts segments into groups.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/placement/groups.h"

#include <algorithm>
#include <map>
#include <set>
#include <utility>

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
  std::vector<Importance> importances;
  for (const Group& group : groups) {
    Importance& sum = importances.emplace_back();
    for (const Segment& segment : group.segments) {
      const Importance one = importance_of(segment);
      sum = {sum.good_frames + one.good_frames, sum.has_poses || one.has_poses};
    }
  }
  return main_index(importances);
}

PoseGraph graph_of(const Group& group, const PlacedMission& placed) {
  PoseGraph graph;
  std::set<int64_t> ids, fixed;  // every segment brings a fixed pose: of those of a group the first stays
  for (const PoseGraph::Node& node : placed.measured.graph.nodes) {
    if (node.is_fixed) fixed.insert(node.id);
  }
  bool has_fixed = false;
  for (const StampedPose& pose : group.trajectory()) {
    ids.insert(pose.sequence);
    const bool is_fixed = !has_fixed && fixed.contains(pose.sequence);
    has_fixed |= is_fixed;
    graph.nodes.push_back({pose.sequence, pose.T_odom_camera, is_fixed});
  }
  for (size_t e = 0; e < placed.measured.graph.edges.size(); ++e) {
    const PoseGraph::Edge& edge = placed.measured.graph.edges[e];
    const bool is_believed = !placed.is_optimised() || placed.solution.edges[e].weight > 0;
    if (is_believed && ids.contains(edge.from)) graph.edges.push_back(edge);
  }
  return graph;
}

}  // namespace kt
