// Whether the information of single edges tells the truth: closures and odometry of a log, one by one.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "shared/io/g2o.h"
#include "shared/types/session.h"
#include "tools/eval/consistency.h"

namespace kt {

struct EdgeConsistency {
  std::optional<Consistency> closures, odometry;  ///< nothing where no edge could be judged
};

/// NEES of each measured T_from_to: xi = log(T_from_to T_from_to_true^-1), a left perturbation, with the
/// inverse of the information that came with it. The truth is that at the frames' stamps, interpolated
/// (poses_at), and counts as exact. Closures are the accepted ones of the log, odometry its good poses, each
/// against the one that it was measured from. With `graph`, a poses.g2o that kintsugi-map made of this log
/// alone, closures are its edges that are not the log's odometry instead: those that were believed. Edges
/// without truth at both ends, or without information in some direction, are left out and counted.
/// Throws kt::Error where the graph names frames that the log does not have.
EdgeConsistency edge_consistency(const Session& session, const Trajectory& groundtruth,
                                 const PoseGraph* graph = nullptr);

}  // namespace kt
