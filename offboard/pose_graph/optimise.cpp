// Decides which loops to believe, then solves.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/pose_graph/optimise.h"

#include "offboard/pose_graph/chordal.h"

namespace kt {

OptimisedGraph optimise(const PoseGraph& graph, std::span<const size_t> loop_edges,
                        const PoseGraphOptions& options) {
  const IndexedGraph indexed_graph = indexed(graph, loop_edges);
  LoopDecision loops;
  loops.weight.assign(graph.edges.size(), 1);
  loops.outcome.assign(graph.edges.size(), LoopOutcome::kAccepted);
  OptimisedGraph result;
  if (options.robustness == LoopRobustness::kGnc && !loop_edges.empty()) {
    loops = decide_loops(indexed_graph);
  }
  result.T_world_node = chordal_initialisation(indexed_graph, loops.weight);
  const LeastSquaresResult solved =
      solve(indexed_graph, loops.weight, options.least_squares, result.T_world_node);

  const std::vector<double> before =
      squared_errors(indexed_graph, GraphResidual::kSe3, indexed_graph.T_world_node);
  const std::vector<double> after = squared_errors(indexed_graph, GraphResidual::kSe3, result.T_world_node);
  for (size_t e = 0; e < graph.edges.size(); ++e) {
    result.edges.push_back({before[e], after[e], loops.weight[e], loops.outcome[e]});
    result.repaired_edges += indexed_graph.edges[e].is_repaired;
  }
  result.components = connected_components(indexed_graph, loops.weight);
  result.objective_before = solved.objective_before;
  result.objective_after = solved.objective_after;
  result.odometry_scale = loops.odometry_scale;
  result.loop_scale = loops.loop_scale;
  result.iterations = solved.iterations;
  result.solves = loops.solves + 1;
  result.converged = solved.converged;
  return result;
}

}  // namespace kt
