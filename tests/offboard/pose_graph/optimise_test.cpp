// Optimising whole graphs: closed forms, odd graphs, and the same bytes every time.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/pose_graph/optimise.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "offboard/pose_graph/chordal.h"
#include "tests/offboard/pose_graph/made_graphs.h"

namespace kt {
namespace {

using testing::ElementsAre;

PoseGraphOptions plain(GraphResidual residual = GraphResidual::kSe3) {
  PoseGraphOptions options;
  options.least_squares.residual = residual;
  options.robustness = LoopRobustness::kNone;
  return options;
}

TEST(Optimise, RecoversPosesFromExactEdgesOverALongWay) {
  const MadeGraph made{.odometry_rad = 1e-9, .odometry_m = 1e-9, .loop_rad = 1e-9, .loop_m = 1e-9};
  const std::vector<Pose> truth = true_poses(made);
  PoseGraph graph = make_graph(made, truth);
  for (size_t k = 1; k < graph.nodes.size(); ++k) graph.nodes[k].T_world_node = Pose::Identity();
  const std::vector<Pose> start = chordal_initialisation(graph);
  for (const GraphResidual residual : {GraphResidual::kSe3, GraphResidual::kChordal}) {
    const OptimisedGraph result = optimise(graph, {}, plain(residual));
    for (size_t k = 0; k < truth.size(); ++k) {
      EXPECT_TRUE(start[k].isApprox(truth[k], 1e-6));
      EXPECT_TRUE(result.T_world_node[k].isApprox(truth[k], 1e-6));
    }
  }
}

TEST(Optimise, TwoMeasurementsOfOneStepAreWeighedByTheirInformation) {
  PoseGraph graph;
  graph.nodes = {{0, Pose::Identity(), true}, {1, Pose::Identity(), false}};
  for (const double x : {1.0, 2.0}) {
    Pose step = Pose::Identity();
    step.translation().x() = x;
    graph.edges.push_back({0, 1, step, (x == 1 ? 3 : 1) * Matrix6d::Identity()});
  }
  const OptimisedGraph result = optimise(graph, {}, plain());
  EXPECT_NEAR(result.T_world_node[1].translation().x(), 1.25, 1e-6);
  EXPECT_NEAR(result.edges[0].chi2_after, 3 * 0.0625, 1e-6);
  EXPECT_NEAR(result.edges[1].chi2_before, 4, 1e-9);
  EXPECT_NEAR(result.objective_after, 0.75, 1e-9);
}

TEST(Optimise, LoopsTakeOutMostOfTheDrift) {
  const MadeGraph made;
  const std::vector<Pose> truth = true_poses(made);
  const PoseGraph graph = make_graph(made, truth);
  std::vector<Pose> odometry;
  for (const PoseGraph::Node& node : graph.nodes) odometry.push_back(node.T_world_node);
  const OptimisedGraph result = optimise(graph, edges_out_of_order(graph), {});
  EXPECT_TRUE(result.converged);
  EXPECT_LT(result.objective_after, result.objective_before);
  EXPECT_LT(position_error(result.T_world_node, truth), 0.3 * position_error(odometry, truth));
}

TEST(Optimise, SameInputGivesTheSameBytes) {
  const MadeGraph made;
  const PoseGraph graph = make_graph(made, true_poses(made));
  const std::vector<size_t> loops = edges_out_of_order(graph);
  const OptimisedGraph a = optimise(graph, loops, {}), b = optimise(graph, loops, {});
  for (size_t k = 0; k < graph.nodes.size(); ++k) {
    EXPECT_EQ(a.T_world_node[k].matrix(), b.T_world_node[k].matrix());
  }
  EXPECT_EQ(a.objective_after, b.objective_after);
}

TEST(Optimise, LostStretchesOfHardlyAnyInformationDoNotKeepItFromConverging) {
  const MadeGraph made;
  const std::vector<Pose> truth = true_poses(made);
  PoseGraph graph = make_graph(made, truth);
  for (int k = 100; k < 110; ++k) {
    graph.edges[k].information.setIdentity();  // 1 rad and 1 m
    graph.edges[k].T_from_to.setIdentity();
  }
  for (size_t e = 0; e < 100; ++e) graph.edges[e].information.diagonal().array() = 1e8;
  const OptimisedGraph result = optimise(graph, {}, plain());
  EXPECT_TRUE(result.converged);
  EXPECT_LT(position_error(result.T_world_node, truth), 0.3);
}

TEST(Optimise, OddGraphsKeepWhatNothingMoves) {
  EXPECT_TRUE(optimise({}, {}, {}).T_world_node.empty());
  PoseGraph graph;
  Pose T = exp_se3((Vector6d() << 0.1, 0.2, 0.3, 4, 5, 6).finished());
  graph.nodes = {{5, T, false}};
  EXPECT_TRUE(optimise(graph, {}, {}).T_world_node[0].isApprox(T, 1e-15));
  graph.nodes.push_back({6, T * T, false});
  graph.edges.push_back({5, 6, T, Matrix6d::Zero()});
  const OptimisedGraph apart = optimise(graph, std::vector<size_t>{0}, {});
  EXPECT_THAT(apart.components.of_node, ElementsAre(0, 1));
  EXPECT_EQ(apart.edges[0].outcome, LoopOutcome::kUninformative);
  EXPECT_TRUE(apart.T_world_node[1].isApprox(T * T, 1e-15));
}

TEST(Optimise, ADirectionLeftOpenKeepsTheGraphSolvable) {
  PoseGraph graph;
  Pose step = Pose::Identity();
  step.translation().x() = 1;
  Matrix6d flat = Matrix6d::Identity();
  flat(4, 4) = 0;
  graph.nodes = {{0, Pose::Identity(), true}, {1, Pose::Identity(), false}, {2, Pose::Identity(), false}};
  graph.edges = {{0, 1, step, flat}, {1, 2, step, flat}};
  const OptimisedGraph result = optimise(graph, {}, plain());
  EXPECT_NEAR(result.T_world_node[2].translation().x(), 2, 1e-6);
  EXPECT_TRUE(result.T_world_node[2].matrix().allFinite());
}

}  // namespace
}  // namespace kt
