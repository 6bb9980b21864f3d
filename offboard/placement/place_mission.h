// Where every frame of a mission was, after all that is known of it.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <vector>

#include "offboard/loop_search/loop_search.h"
#include "offboard/pose_graph/mission_graph.h"
#include "offboard/pose_graph/optimise.h"
#include "shared/types/session.h"

namespace kt {

/// Which loop closures are used.
enum class LoopSource {
  kSearch,  ///< those of a search among all keyframes
  kLog,     ///< those that the collector found
  kNone,
};

struct PlacementConfig {
  LoopSource loops = LoopSource::kSearch;
  LoopSearchConfig search{};
  PoseGraphOptions graph{};
  int threads = 0;
};

struct PlacedMission {
  std::vector<Pose> T_world_camera;     ///< by pose of the trajectory
  std::vector<int> group;               ///< by pose: poses of one group stand in one frame
  std::vector<LoopClosure> candidates;  ///< all that were compared, with the verdict of the proof
  MissionGraph measured;                ///< poses as logged, and the accepted candidates as edges
  OptimisedGraph solution;              ///< of `measured`; empty where no loop was accepted
  bool is_optimised() const { return !solution.T_world_node.empty(); }
  /// The closures that the optimiser kept.
  std::vector<LoopClosure> believed_closures() const;
};

/// Finds loop closures and optimises the pose graph; searches twice, for better poses show what else is near.
/// The first good pose of each group stands where odometry has it; without loops all do, to the bit.
PlacedMission place_mission(const Session& session, const PlacementConfig& config,
                            const std::function<void(double share)>& progress);

}  // namespace kt
