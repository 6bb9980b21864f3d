// Search, optimise, search again; and optimise once more.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/placement/place_mission.h"

#include <algorithm>
#include <map>
#include <utility>

namespace kt {
namespace {

// Index of the pose of each frame.
std::map<int64_t, size_t> indices_by_sequence(const Trajectory& poses) {
  std::map<int64_t, size_t> indices;
  for (size_t i = 0; i < poses.size(); ++i) indices.emplace(poses[i].sequence, i);
  return indices;
}

constexpr double kFirst = 0.7;  // of the work, the first time

// The keyframes whose poses are there, and what is known of these.
class Searched {
 public:
  Searched(const Session& session, const LoopSearchConfig& config, int threads)
      : session_(session), search_(session.header.calibration, keyframes(), config, threads) {}

  void look(const PlacedMission& placed, std::vector<LoopClosure>& candidates, const LoopProgress& progress) {
    std::vector<Pose> T_world_camera;
    std::vector<int> group;
    for (const size_t i : at_) {
      T_world_camera.push_back(placed.T_world_camera[i]);
      group.push_back(placed.group[i]);
    }
    for (LoopClosure& loop : search_.search(T_world_camera, group, progress))
      candidates.push_back(std::move(loop));
  }

 private:
  std::vector<Keyframe> keyframes() {
    const std::map<int64_t, size_t> indices = indices_by_sequence(session_.trajectory);
    std::vector<Keyframe> keyframes;
    for (const Keyframe& keyframe : session_.keyframes) {
      const auto found = indices.find(keyframe.sequence);
      if (found == indices.end()) continue;  // a damaged log has lost its pose
      keyframes.push_back(keyframe);
      at_.push_back(found->second);
    }
    return keyframes;
  }

  const Session& session_;
  std::vector<size_t> at_;  // index of the pose of each keyframe
  LoopSearch search_;
};

}  // namespace

std::vector<LoopClosure> PlacedMission::believed_closures() const {
  std::vector<LoopClosure> believed;
  for (size_t k = 0; k < measured.loops.size(); ++k) {
    if (solution.edges[measured.loop_edges[k]].weight > 0) believed.push_back(candidates[measured.loops[k]]);
  }
  return believed;
}

std::vector<LoopClosure> find_loops(const Session& session, const LoopOptions& config, int threads,
                                    const std::function<void(double)>& progress) {
  if (config.source == LoopSource::kLog) return session.loop_closures;
  // A log that has lost its session event has lost its camera too.
  if (config.source == LoopSource::kNone || session.integrity.session_missing) return {};
  std::vector<LoopClosure> candidates;
  Searched searched(session, config.search, threads);
  searched.look(placed_mission(session, {}, {}, {}), candidates,
                [&](double share) { progress(kFirst * share); });
  MissionGraph measured = mission_graph(session.trajectory, candidates);
  OptimisedGraph solution = solve_mission(measured, {});
  const PlacedMission placed = placed_mission(session, {}, std::move(measured), std::move(solution));
  if (placed.is_optimised())
    searched.look(placed, candidates, [&](double share) { progress(kFirst + (1 - kFirst) * share); });
  return candidates;
}

OptimisedGraph solve_mission(const MissionGraph& measured, const PoseGraphOptions& options) {
  if (measured.loop_edges.empty()) return {};
  return optimise(measured.graph, measured.loop_edges, options);
}

PlacedMission placed_mission(const Session& session, std::vector<LoopClosure> candidates,
                             MissionGraph measured, OptimisedGraph solution) {
  PlacedMission placed;
  placed.candidates = std::move(candidates);
  placed.measured = std::move(measured);
  placed.solution = std::move(solution);
  if (placed.is_optimised()) {
    placed.T_world_camera = placed.solution.T_world_node;
    placed.group = placed.solution.components.of_node;
    return placed;
  }
  for (const StampedPose& pose : session.trajectory) {
    placed.T_world_camera.push_back(pose.T_odom_camera);
    placed.group.push_back(pose.segment);
  }
  return placed;
}

}  // namespace kt
