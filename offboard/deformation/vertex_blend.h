// Which nodes move a point, and by what share each.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>

#include "offboard/deformation/deformation_graph.h"

namespace kt {

inline constexpr int kMaxBlendNodes = 8;

/// Nodes of a graph, nearest first, with weights that sum to 1.
struct VertexBlend {
  int count = 0;  ///< 0 only where the graph has no node
  std::array<int, kMaxBlendNodes> node{};
  std::array<double, kMaxBlendNodes> weight{};
};

/// Back-traversal association (Whelan et al. 2013): from the node nearest in time to `pose_sequence`, which
/// need not be that of a logged pose, the look_back nodes before it are candidates, and as many after it as
/// are missing at the start of the path. So a vertex hangs on nodes of the pass that saw it, though nodes of
/// another pass may stand nearer.
///
/// The k candidates nearest to the finite point p_odom (m) move it, of equals the nearer in time, by the
/// weights (1 - d / d_max)^2 (the paper's eq. 5), where d_max is the distance of the one after them. A graph
/// of no more than k nodes has no such one: all of them then move the point, and d_max lies node_spacing_m
/// beyond the farthest. Where all weights would vanish they are equal.
VertexBlend blend_at(const DeformationGraph& graph, const Eigen::Vector3d& p_odom, int64_t pose_sequence);

}  // namespace kt
