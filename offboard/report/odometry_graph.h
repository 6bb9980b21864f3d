// A segment as a pose graph.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>

#include "shared/io/g2o.h"
#include "shared/types/loop_closure.h"
#include "shared/types/stamped_pose.h"

namespace kt {

/// One node per pose, in the order of `poses` and so of the lines of trajectory.txt (its id is the frame's
/// sequence; the first is fixed). Then one edge to each pose from the one it was measured against, with the
/// information that the collector gave it; after these, one for each accepted loop closure between
/// poses that are there. `poses` are of one segment and ascend by sequence. An edge that begins at a pose
/// that is not among them is left out: one that a damaged log has lost, or one of another segment, which
/// stands in a frame of its own.
PoseGraph odometry_graph(const Trajectory& poses, std::span<const LoopClosure> loop_closures);

}  // namespace kt
