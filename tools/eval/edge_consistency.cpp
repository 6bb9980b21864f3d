// Holds each edge against the true motion between its frames.
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/eval/edge_consistency.h"

#include <algorithm>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "shared/core/check.h"
#include "tools/eval/groundtruth.h"

namespace kt {
namespace {

/// The true poses, by sequence; none where the truth has no pose near the stamp, or ends before it.
std::map<int64_t, std::optional<Pose>> truth_of(const Trajectory& poses, const Trajectory& groundtruth) {
  const auto [first, last] =
      std::ranges::minmax(groundtruth, {}, [](const StampedPose& pose) { return pose.timestamp_us; });
  std::vector<int64_t> stamps_us;
  for (const StampedPose& pose : poses) stamps_us.push_back(pose.timestamp_us);
  const std::vector<std::optional<Pose>> truth = poses_at(groundtruth, stamps_us);
  std::map<int64_t, std::optional<Pose>> result;
  for (size_t k = 0; k < poses.size(); ++k) {
    const bool is_known = stamps_us[k] >= first.timestamp_us && stamps_us[k] <= last.timestamp_us;
    result.emplace(poses[k].sequence, is_known ? truth[k] : std::nullopt);
  }
  return result;
}

std::vector<PoseGraph::Edge> odometry_of(const Trajectory& poses) {
  std::map<int64_t, const StampedPose*> by_sequence;
  for (const StampedPose& pose : poses) by_sequence.emplace(pose.sequence, &pose);
  std::vector<PoseGraph::Edge> edges;
  for (const StampedPose& pose : poses) {
    const auto from = by_sequence.find(pose.from_sequence);
    if (pose.status != TrackingStatus::kGood || pose.from_sequence == pose.sequence ||
        from == by_sequence.end() || from->second->segment != pose.segment)
      continue;
    edges.push_back({pose.from_sequence, pose.sequence,
                     from->second->T_odom_camera.inverse(Eigen::Isometry) * pose.T_odom_camera,
                     pose.information});
  }
  return edges;
}

std::vector<PoseGraph::Edge> closures_of(const Session& session) {
  std::vector<PoseGraph::Edge> edges;
  for (const LoopClosure& loop : session.loop_closures) {
    if (loop.accepted()) edges.push_back({loop.from, loop.to, loop.T_from_to, loop.information});
  }
  return edges;
}

std::vector<PoseGraph::Edge> closures_of(const PoseGraph& graph, const Trajectory& poses) {
  std::set<std::pair<int64_t, int64_t>> odometry;
  std::map<int, int64_t> last;  // sequence, by segment: what an edge begins at whose own start is lost
  for (const StampedPose& pose : poses) {
    odometry.emplace(pose.from_sequence, pose.sequence);
    if (const auto before = last.find(pose.segment); before != last.end())
      odometry.emplace(before->second, pose.sequence);
    last[pose.segment] = pose.sequence;
  }
  std::vector<PoseGraph::Edge> edges;
  for (const PoseGraph::Edge& edge : graph.edges) {
    if (!odometry.contains({edge.from, edge.to})) edges.push_back(edge);
  }
  return edges;
}

}  // namespace

EdgeConsistency edge_consistency(const Session& session, const Trajectory& groundtruth,
                                 const PoseGraph* graph) {
  const std::map<int64_t, std::optional<Pose>> truth = truth_of(session.trajectory, groundtruth);
  const auto judged = [&truth](const std::vector<PoseGraph::Edge>& edges) {
    NeesSamples samples;
    int64_t left_out = 0;
    for (const PoseGraph::Edge& edge : edges) {
      const auto from = truth.find(edge.from), to = truth.find(edge.to);
      if (from == truth.end() || to == truth.end()) {
        throw Error("the log has no pose of frame " +
                    std::to_string(from == truth.end() ? edge.from : edge.to) +
                    ", which an edge names: they are not of one mission");
      }
      const std::optional<Matrix6d> covariance = covariance_of(edge.information);
      if (!from->second || !to->second || !covariance) {
        ++left_out;
        continue;
      }
      const Pose T_to_from_true = to->second->inverse(Eigen::Isometry) * *from->second;
      samples.add(log_se3(edge.T_from_to * T_to_from_true), *covariance);
    }
    return samples.summary(left_out);
  };
  return {judged(graph ? closures_of(*graph, session.trajectory) : closures_of(session)),
          judged(odometry_of(session.trajectory))};
}

}  // namespace kt
