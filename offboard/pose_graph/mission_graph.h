// A mission as a pose graph.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include "shared/io/g2o.h"
#include "shared/types/loop_closure.h"
#include "shared/types/stamped_pose.h"

namespace kt {

struct MissionGraph {
  PoseGraph graph;
  std::vector<size_t> loop_edges;  ///< indices of those edges that are loop closures, which may be false
  std::vector<size_t> loops;       ///< for each of them the index of its closure
};

/// One node per pose, in the order of `poses` and so of the lines of trajectory.txt (its id is the frame's
/// sequence); the first good one of each segment is fixed. Then one edge to each pose from the one it was
/// measured against, with the information that the collector gave it; after these, one for each accepted loop
/// closure between poses that are there. `poses` ascend by sequence. Where the pose that an edge begins at is
/// not among them, for a damaged log has lost it, the edge begins at the segment's pose before, less sure by
/// as many times as frames lie between. A segment stands in a frame of its own: none begins in another.
MissionGraph mission_graph(const Trajectory& poses, std::span<const LoopClosure> loop_closures);

}  // namespace kt
