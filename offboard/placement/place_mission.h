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

struct LoopConfig {
  LoopSource source = LoopSource::kSearch;
  LoopSearchConfig search{};
};

struct PlacedMission {
  std::vector<Pose> T_world_camera;     ///< by pose of the trajectory
  std::vector<int> group;               ///< by pose: poses of one group stand in one frame
  std::vector<LoopClosure> candidates;  ///< all that were compared, with the verdict of the proof
  MissionGraph measured;                ///< poses as logged, and the accepted candidates as edges
  OptimisedGraph solution;              ///< of `measured`; empty where no loop was accepted
  bool is_optimised() const { return !solution.T_world_node.empty(); }
};

/// All candidates for loop closures that were compared, with the verdict of the proof. A search looks twice:
/// better poses, for which it optimises the graph with the usual options, show what else is near. The result
/// does not depend on the number of threads.
std::vector<LoopClosure> find_loops(const Session& session, const LoopConfig& config, int threads,
                                    const std::function<void(double share)>& progress);

/// `measured` optimised; an empty solution where no loop was accepted.
OptimisedGraph solve_mission(const MissionGraph& measured, const PoseGraphOptions& options);

/// Where a solution has put every frame. The first good pose of each group stands where odometry has it;
/// without loops all do, to the bit.
PlacedMission placed_mission(const Session& session, std::vector<LoopClosure> candidates,
                             MissionGraph measured, OptimisedGraph solution);

}  // namespace kt
