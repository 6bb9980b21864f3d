// One weighted least squares solve of a pose graph, by Ceres.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include "offboard/pose_graph/indexed_graph.h"

namespace kt {

/// What is squared and summed over the edges.
enum class GraphResidual {
  kSe3,      ///< e^T information e, e the left perturbation between measured and present T_from_to
  kChordal,  ///< the terms of chordal_objective(), as the SE-Sync benchmark has it
};

/// How the linear system of each step is solved.
enum class LinearSolver {
  kCholesky,  ///< exactly: the fewest steps, but dear where loops tie everything to everything
  /// Conjugate gradients, stopped early. Odometry and those loops that err least are the preconditioner, as
  /// many of them as keep its factorisation below kDearFactorisation.
  kConjugateGradients,
};

struct LeastSquaresOptions {
  GraphResidual residual = GraphResidual::kSe3;
  LinearSolver linear_solver = LinearSolver::kCholesky;
  int max_iterations = 100;
  double relative_tolerance = 1e-9;  ///< stop where a step lowers the objective by less than this share
};

struct LeastSquaresResult {
  double objective_before = 0, objective_after = 0;
  int iterations = 0;
  bool converged = true;  ///< false where max_iterations came first
};

/// Levenberg-Marquardt from `T_world_node`, which is replaced. Each connected component is first moved to its
/// anchor (see Components), which stays there. `weight`, one per edge, multiplies its square; empty: 1. One
/// thread, Eigen's sparse Cholesky, no clock: the same input gives the same bytes. Throws kt::Error where the
/// solver fails.
LeastSquaresResult solve(const IndexedGraph& graph, std::span<const double> weight,
                         const LeastSquaresOptions& options, std::vector<Pose>& T_world_node);

/// The square of each edge's residual at `T_world_node`, without weights.
std::vector<double> squared_errors(const IndexedGraph& graph, GraphResidual residual,
                                   std::span<const Pose> T_world_node);

}  // namespace kt
