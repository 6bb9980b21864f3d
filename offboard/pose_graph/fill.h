// What a sparse Cholesky factorisation of a pose graph costs, from its edges alone.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>

#include "offboard/pose_graph/indexed_graph.h"

namespace kt {

/// Sum over the nodes, in the order of approximate minimum degree, of the square of their column's length in
/// the factor: multiplications of 6x6 blocks that the factorisation takes. Edges of weight 0 and
/// uninformative ones are left out; empty `weight`: 1. Takes time by the length of the factor, not its
/// square.
double factorisation_cost(const IndexedGraph& graph, std::span<const double> weight);

/// Beyond this cost, some tens of milliseconds, conjugate gradients are faster.
inline constexpr double kDearFactorisation = 5e5;

}  // namespace kt
