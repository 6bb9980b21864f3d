// Scale of odometry, joining of segments, gate, and graduated non-convexity.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/pose_graph/robust_loops.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "offboard/pose_graph/chordal.h"
#include "offboard/pose_graph/fill.h"
#include "offboard/pose_graph/least_squares.h"
#include "offboard/pose_graph/loop_consistency.h"
#include "offboard/pose_graph/odometry_forest.h"

namespace kt {
namespace {

/// Most loops between two segments that are tried as the one to join them by.
constexpr size_t kMaxJoiningTried = 200;

/// `graph` with the covariances of odometry and loops multiplied.
IndexedGraph scaled(const IndexedGraph& graph, double odometry_scale, double loop_scale) {
  IndexedGraph result = graph;
  for (IndexedEdge& edge : result.edges) {
    const double scale = edge.is_loop ? loop_scale : odometry_scale;
    edge.information /= scale;
    edge.chordal.kappa /= scale;
    edge.chordal.tau /= scale;
  }
  return result;
}

/// Adds, to the scales of odometry, one loop for each two segments that enough of the `usable` loops join.
std::vector<double> joined(const IndexedGraph& graph, const std::vector<char>& usable) {
  std::vector<double> scales = odometry_only(graph);
  for (;;) {
    const OdometryForest forest(graph, scales);
    std::map<std::pair<int, int>, std::vector<size_t>> loops_of_trees;
    for (size_t e = 0; e < graph.edges.size(); ++e) {
      const IndexedEdge& edge = graph.edges[e];
      if (!edge.is_loop || !usable[e]) continue;
      const int a = forest.tree(edge.from), b = forest.tree(edge.to);
      if (a != b) loops_of_trees[std::minmax(a, b)].push_back(e);
    }
    int most = kLoopsToJoin - 1;
    size_t best = 0;
    for (const auto& [trees, loops] : loops_of_trees) {
      const size_t step = 1 + (loops.size() - 1) / kMaxJoiningTried;
      for (size_t tried = 0; tried < loops.size(); tried += step) {
        const IndexedEdge& one = graph.edges[loops[tried]];
        const auto agrees = [&](size_t e) {
          return cycle_squared_sigmas(forest, one, graph.edges[e]) < kGate;
        };
        const int agreeing = static_cast<int>(std::count_if(loops.begin(), loops.end(), agrees));
        if (agreeing > most) most = agreeing, best = loops[tried];
      }
    }
    if (most < kLoopsToJoin) return scales;
    scales[best] = 1;
  }
}

/// joined(), for the measurement of scales: what joins segments counts as exact, so that short ways over it
/// tell nothing of odometry. Long ones may have no loop within one segment.
std::vector<double> exactly_joined(const IndexedGraph& graph, const std::vector<char>& usable) {
  constexpr double kExact = 1e-6;
  std::vector<double> scales = joined(graph, usable);
  for (size_t e = 0; e < graph.edges.size(); ++e) {
    if (graph.edges[e].is_loop && scales[e] > 0) scales[e] = kExact;
  }
  return scales;
}

/// Rejects the loops between trees of `forest`.
void reject_unconfirmed(const IndexedGraph& graph, const OdometryForest& forest, LoopDecision& decision) {
  for (size_t e = 0; e < graph.edges.size(); ++e) {
    const IndexedEdge& edge = graph.edges[e];
    if (!edge.is_loop || decision.weight[e] <= 0 || forest.tree(edge.from) == forest.tree(edge.to)) continue;
    decision.weight[e] = 0;
    decision.outcome[e] = LoopOutcome::kUnconfirmed;
  }
}

std::vector<char> accepted_loops(const IndexedGraph& graph, const LoopDecision& decision) {
  std::vector<char> result;
  for (size_t e = 0; e < graph.edges.size(); ++e) {
    result.push_back(graph.edges[e].is_loop && decision.weight[e] > 0);
  }
  return result;
}

/// Divides the information of each loop of weight > 0 by the number of those beside it, itself included:
/// neighbours are wrong together, where one place looks like another, and so have one vote together.
void share_votes(const OdometryForest& forest, const std::vector<double>& weight, IndexedGraph& graph) {
  std::vector<IndexedEdge*> loops;
  for (size_t e = 0; e < graph.edges.size(); ++e) {
    if (graph.edges[e].is_loop && weight[e] > 0) loops.push_back(&graph.edges[e]);
  }
  std::vector<double> neighbours;
  for (const IndexedEdge* one : loops) {
    neighbours.push_back(
        static_cast<double>(std::count_if(loops.begin(), loops.end(), [&](IndexedEdge* other) {
          return forest.is_near(one->from, other->from, kVoteReach) &&
                 forest.is_near(one->to, other->to, kVoteReach);
        })));
  }
  for (size_t k = 0; k < loops.size(); ++k) {
    loops[k]->information /= neighbours[k];
    loops[k]->chordal.kappa /= neighbours[k];
    loops[k]->chordal.tau /= neighbours[k];
  }
}

/// Yang et al. 2020, eq. 14: weight of a residual in truncated least squares at convexity `mu`.
double truncated_weight(double square, double threshold, double mu) {
  if (square >= (mu + 1) / mu * threshold) return 0;
  if (square <= mu / (mu + 1) * threshold) return 1;
  return std::sqrt(threshold / square * mu * (mu + 1)) - mu;
}

LinearSolver fast_solver(const IndexedGraph& graph, const std::vector<double>& weight) {
  return factorisation_cost(graph, weight) > kDearFactorisation ? LinearSolver::kConjugateGradients
                                                                : LinearSolver::kCholesky;
}

/// Moves `T_world_node` towards the optimum for these weights, which the next ones will move again.
void approach(const IndexedGraph& graph, const std::vector<double>& weight, LoopDecision& decision,
              std::vector<Pose>& T_world_node) {
  LeastSquaresOptions options;
  options.linear_solver = fast_solver(graph, weight);
  options.max_iterations = options.linear_solver == LinearSolver::kCholesky ? 10 : 3;
  options.relative_tolerance = 1e-4;
  solve(graph, weight, options, T_world_node);
  ++decision.solves;
}

void graduate(const IndexedGraph& graph, LoopDecision& decision, std::vector<Pose>& T_world_node) {
  constexpr double kMuStep = 1.4;  // as in the paper
  const std::vector<char> is_tried = accepted_loops(graph, decision);
  std::vector<double> weight = decision.weight;
  double mu = 0;
  for (;;) {
    approach(graph, weight, decision, T_world_node);
    const std::vector<double> squares = squared_errors(graph, GraphResidual::kSe3, T_world_node);
    double largest = 0;
    for (size_t e = 0; e < squares.size(); ++e) {
      if (is_tried[e]) largest = std::max(largest, squares[e]);
    }
    if (mu == 0) {
      if (largest <= kTruncation) return;
      mu = kTruncation / (2 * largest - kTruncation);
    }
    bool is_undecided = false;
    for (size_t e = 0; e < squares.size(); ++e) {
      if (!is_tried[e]) continue;
      weight[e] = truncated_weight(squares[e], kTruncation, mu);
      is_undecided |= weight[e] > 0 && weight[e] < 1;
    }
    if (!is_undecided) break;
    mu *= kMuStep;
  }
  // A true loop with the bad luck of the one in a hundred is where the others want it all the same; and those
  // that come back draw the poses to where more of them are.
  for (bool has_grown = true; has_grown;) {
    approach(graph, weight, decision, T_world_node);
    const std::vector<double> squares = squared_errors(graph, GraphResidual::kSe3, T_world_node);
    has_grown = false;
    for (size_t e = 0; e < weight.size(); ++e) {
      if (!is_tried[e] || weight[e] > 0 || squares[e] >= kGate) continue;
      weight[e] = 1;
      has_grown = true;
    }
  }
  for (size_t e = 0; e < weight.size(); ++e) {
    if (!is_tried[e] || weight[e] > 0) continue;
    decision.weight[e] = 0;
    decision.outcome[e] = LoopOutcome::kInconsistent;
  }
}

}  // namespace

const char* to_string(LoopOutcome outcome) {
  switch (outcome) {
    case LoopOutcome::kAccepted:
      return "accepted";
    case LoopOutcome::kUnconfirmed:
      return "unconfirmed";
    case LoopOutcome::kAgainstOdometry:
      return "against odometry";
    case LoopOutcome::kInconsistent:
      return "inconsistent";
    case LoopOutcome::kUninformative:
      return "uninformative";
  }
  return "";
}

LoopDecision decide_loops(const IndexedGraph& given) {
  LoopDecision decision;
  decision.weight.assign(given.edges.size(), 1);
  decision.outcome.assign(given.edges.size(), LoopOutcome::kAccepted);
  for (size_t e = 0; e < given.edges.size(); ++e) {
    if (!given.edges[e].is_loop || given.edges[e].is_informative()) continue;
    decision.weight[e] = 0;
    decision.outcome[e] = LoopOutcome::kUninformative;
  }
  // Each scale is read where the other covariance hardly counts, which the other's scale decides: so they are
  // measured by turns. A third time, for ways whose odometry counts once the loops are known to be good.
  IndexedGraph graph = given;
  for (int round = 0; round < 3; ++round) {
    const std::vector<double> ways = exactly_joined(graph, accepted_loops(graph, decision));
    graph = scaled(given, 1, decision.loop_scale);
    decision.odometry_scale = measured_odometry_scale(graph, OdometryForest(graph, ways));
    graph = scaled(given, decision.odometry_scale, 1);
    // Of one segment: logs that share a stretch hold the same images twice, and such loops err alike.
    decision.loop_scale = measured_loop_scale(graph, OdometryForest(graph, odometry_only(graph)));
    graph = scaled(given, decision.odometry_scale, decision.loop_scale);
  }

  const auto join = [&] { return OdometryForest(graph, joined(graph, accepted_loops(graph, decision))); };
  const OdometryForest forest = join();
  reject_unconfirmed(graph, forest, decision);
  for (size_t e = 0; e < graph.edges.size(); ++e) {
    const IndexedEdge& edge = graph.edges[e];
    if (!edge.is_loop || decision.weight[e] <= 0) continue;
    if (squared_sigmas(edge, forest.between(edge.from, edge.to)) < kGate) continue;
    decision.weight[e] = 0;
    decision.outcome[e] = LoopOutcome::kAgainstOdometry;
  }
  std::vector<Pose> T_world_node =
      chordal_initialisation(graph, decision.weight, fast_solver(graph, decision.weight));
  share_votes(forest, decision.weight, graph);
  graduate(graph, decision, T_world_node);
  reject_unconfirmed(graph, join(), decision);  // fewer may be left that agree
  return decision;
}

}  // namespace kt
