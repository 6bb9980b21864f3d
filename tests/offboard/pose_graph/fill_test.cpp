// What factorisations cost, and that conjugate gradients find what they find.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/pose_graph/fill.h"

#include <gtest/gtest.h>

#include "offboard/pose_graph/chordal.h"
#include "offboard/pose_graph/optimise.h"
#include "tests/offboard/pose_graph/made_graphs.h"
#include "tools/graph/false_loops.h"

namespace kt {
namespace {

IndexedGraph made(int nodes, int loops) {
  const MadeGraph options{.nodes = nodes, .loops = loops};
  const PoseGraph graph = make_graph(options, true_poses(options));
  return indexed(graph, edges_out_of_order(graph));
}

TEST(FactorisationCost, OfAChainIsTwoBlocksAColumn) {
  EXPECT_EQ(factorisation_cost(made(300, 0), {}), 4 * 299 + 1);
}

TEST(FactorisationCost, OfACompleteGraphIsThatOfADenseMatrix) {
  IndexedGraph graph = made(40, 0);
  const IndexedEdge pattern = graph.edges[0];
  for (int i = 0; i < 40; ++i) {
    for (int j = 0; j < i; ++j) {
      IndexedEdge& edge = graph.edges.emplace_back(pattern);
      edge.from = i, edge.to = j;
    }
  }
  EXPECT_EQ(factorisation_cost(graph, {}), 40 * 41 * 81 / 6);
}

TEST(FactorisationCost, EdgesThatDoNotCountCostNothing) {
  IndexedGraph graph = made(300, 40);
  std::vector<double> weight;
  for (const IndexedEdge& edge : graph.edges) weight.push_back(edge.is_loop ? 0 : 0.5);
  EXPECT_EQ(factorisation_cost(graph, weight), 4 * 299 + 1);
  EXPECT_GT(factorisation_cost(graph, {}), 4 * 299 + 1);
}

TEST(ConjugateGradients, ReachTheSameOptimum) {
  const IndexedGraph graph = made(300, 200);
  std::vector<Pose> by_cholesky = chordal_initialisation(graph, {});
  std::vector<Pose> by_gradients = chordal_initialisation(graph, {}, LinearSolver::kConjugateGradients);
  const auto largest_difference = [&] {
    double largest = 0;
    for (size_t k = 0; k < by_cholesky.size(); ++k) {
      largest = std::max(largest, movement(by_cholesky[k].inverse(Eigen::Isometry) * by_gradients[k]));
    }
    return largest;
  };
  EXPECT_LT(largest_difference(), 0.01);
  LeastSquaresOptions options;
  const double exact = solve(graph, {}, options, by_cholesky).objective_after;
  options.linear_solver = LinearSolver::kConjugateGradients;
  EXPECT_NEAR(solve(graph, {}, options, by_gradients).objective_after, exact, 1e-3 * exact);
  EXPECT_LT(largest_difference(), 0.01);
}

TEST(ConjugateGradients, HundredsOfFalseLoopsAreFoundThroughThem) {
  const MadeGraph options{.nodes = 600, .loops = 600};
  const std::vector<Pose> truth = true_poses(options);
  const PoseGraph right = make_graph(options, truth);
  const PoseGraph spoilt = with_false_loops(right, {.share = 0.3, .kind = FalseLoopKind::kAlias, .seed = 1});
  const std::vector<size_t> loops = edges_out_of_order(spoilt);
  ASSERT_GT(factorisation_cost(indexed(spoilt, loops), {}), kDearFactorisation);
  const OptimisedGraph result = optimise(spoilt, loops, {});
  int true_rejected = 0, false_accepted = 0;
  for (const size_t loop : loops) {
    const bool is_accepted = result.edges[loop].outcome == LoopOutcome::kAccepted;
    (loop < right.edges.size() ? true_rejected += !is_accepted : false_accepted += is_accepted);
  }
  EXPECT_LE(true_rejected, 30);
  EXPECT_LE(false_accepted, 2);
  EXPECT_LT(position_error(result.T_world_node, truth), 0.03);
}

}  // namespace
}  // namespace kt
