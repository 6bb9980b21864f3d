// The most likely poses of a graph whose loop closures may be false.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include "offboard/pose_graph/least_squares.h"
#include "offboard/pose_graph/robust_loops.h"

namespace kt {

enum class LoopRobustness {
  kNone,  ///< every loop is believed
  kGnc,   ///< decide_loops() says which
};

struct PoseGraphOptions {
  LeastSquaresOptions least_squares;
  LoopRobustness robustness = LoopRobustness::kGnc;
};

struct OptimisedEdge {
  double chi2_before = 0, chi2_after = 0;  ///< e^T information e, in sigmas squared, whatever was minimised
  double weight = 1;                       ///< 0 where it is a loop that is not accepted
  LoopOutcome outcome = LoopOutcome::kAccepted;
};

struct OptimisedGraph {
  std::vector<Pose> T_world_node;    ///< in the order of graph.nodes
  std::vector<OptimisedEdge> edges;  ///< in the order of graph.edges
  /// Nodes held together by odometry and accepted loops; of different components nobody knows how they stand
  /// to each other, and an edge between them has no meaningful chi2.
  Components components;
  double objective_before = 0;  ///< at the chordal start of the last solve, accepted edges only
  double objective_after = 0;
  /// Factors on the covariances of odometry and loops, as decide_loops() measured them; the objective has
  /// them not.
  double odometry_scale = 1, loop_scale = 1;
  int iterations = 0;      ///< of the last solve
  int solves = 1;          ///< least squares problems, those of decide_loops() among them
  int repaired_edges = 0;  ///< whose information was indefinite, see indexed()
  bool converged = true;
};

/// Minimises the sum of squares of `options.residual` over all poses, from a chordal start; `loop_edges` are
/// the indices of edges that may be false, all others are odometry and always count in full. Each component
/// keeps the pose of its anchor: the first fixed node, else the first. The result depends on nothing but the
/// arguments. Throws kt::Error where the graph is not well formed (see indexed()) or the solver fails.
OptimisedGraph optimise(const PoseGraph& graph, std::span<const size_t> loop_edges,
                        const PoseGraphOptions& options);

}  // namespace kt
