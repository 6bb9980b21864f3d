// False loop closures for a pose graph, to see what an optimiser makes of them.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "shared/io/g2o.h"

namespace kt {

enum class FalseLoopKind {
  kRandom,  ///< random pairs of nodes with random relative poses, up to half the graph's extent
  /// Places that look alike: groups of kAliasGroup loops between two random stretches, with the relative pose
  /// of a true loop, each consistent with the others and the node poses.
  kAlias,
};
inline constexpr int kAliasGroup = 5;

struct FalseLoops {
  double share = 0.3;  ///< of all loops, afterwards; in [0, 1)
  FalseLoopKind kind = FalseLoopKind::kRandom;
  uint64_t seed = 1;
};

/// `graph` with false loops appended to its edges, with the information of true ones. True loops are the
/// edges between nodes that are not consecutive. Throws kt::Error where it has none, or too few nodes.
PoseGraph with_false_loops(const PoseGraph& graph, const FalseLoops& options);

}  // namespace kt
