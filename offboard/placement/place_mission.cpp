// Search, optimise, search again, optimise.
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

std::vector<int> segments_of(const Trajectory& poses) {
  std::vector<int> segments;
  for (const StampedPose& pose : poses) segments.push_back(pose.segment);
  return segments;
}

constexpr double kSearch = 0.7;  // of the work, the first time

class Placing {
 public:
  Placing(const Session& session, const PlacementConfig& config) : session_(session), config_(config) {
    for (const StampedPose& pose : session.trajectory) placed_.T_world_camera.push_back(pose.T_odom_camera);
    placed_.group = segments_of(session.trajectory);
  }

  PlacedMission run(const std::function<void(double)>& progress) {
    if (config_.loops == LoopSource::kLog) placed_.candidates = session_.loop_closures;
    // A log that has lost its session event has lost its camera too.
    const bool has_camera = session_.header.calibration.problem().empty();
    if (config_.loops == LoopSource::kSearch && has_camera) {
      const std::map<int64_t, size_t> indices = indices_by_sequence(session_.trajectory);
      std::vector<Keyframe> keyframes;
      std::vector<size_t> at;  // index of the pose of each
      for (const Keyframe& keyframe : session_.keyframes) {
        const auto found = indices.find(keyframe.sequence);
        if (found == indices.end()) continue;  // a damaged log has lost its pose
        keyframes.push_back(keyframe);
        at.push_back(found->second);
      }
      LoopSearch search(session_.header.calibration, std::move(keyframes), config_.search, config_.threads);
      look(search, at, [&](double share) { progress(kSearch * share); });
      optimise_poses();
      if (placed_.is_optimised())
        look(search, at, [&](double share) { progress(kSearch + (1 - kSearch) * share); });
    }
    optimise_poses();
    return std::move(placed_);
  }

 private:
  void look(LoopSearch& search, const std::vector<size_t>& at, const LoopProgress& progress) {
    std::vector<Pose> T_world_camera;
    std::vector<int> group;
    for (const size_t i : at) {
      T_world_camera.push_back(placed_.T_world_camera[i]);
      group.push_back(placed_.group[i]);
    }
    for (LoopClosure& loop : search.search(T_world_camera, group, progress))
      placed_.candidates.push_back(std::move(loop));
  }

  void optimise_poses() {
    placed_.measured = mission_graph(session_.trajectory, placed_.candidates);
    if (placed_.measured.loop_edges.empty()) return;
    placed_.solution = optimise(placed_.measured.graph, placed_.measured.loop_edges, config_.graph);
    placed_.T_world_camera = placed_.solution.T_world_node;
    placed_.group = placed_.solution.components.of_node;
  }

  const Session& session_;
  const PlacementConfig& config_;
  PlacedMission placed_;
};

}  // namespace

std::vector<LoopClosure> PlacedMission::believed_closures() const {
  std::vector<LoopClosure> believed;
  for (size_t k = 0; k < measured.loops.size(); ++k) {
    if (solution.edges[measured.loop_edges[k]].weight > 0) believed.push_back(candidates[measured.loops[k]]);
  }
  return believed;
}

PlacedMission place_mission(const Session& session, const PlacementConfig& config,
                            const std::function<void(double)>& progress) {
  return Placing(session, config).run(progress);
}

}  // namespace kt
