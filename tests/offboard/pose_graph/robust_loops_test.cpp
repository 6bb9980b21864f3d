// False loops are found, true ones are kept, and segments are joined only by loops that agree.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/pose_graph/robust_loops.h"

#include <gtest/gtest.h>

#include "offboard/pose_graph/optimise.h"
#include "tests/offboard/pose_graph/made_graphs.h"
#include "tools/graph/false_loops.h"

namespace kt {
namespace {

struct Run {
  OptimisedGraph result;
  int true_rejected = 0, false_accepted = 0;
};

/// The first `true_edges` edges are right.
Run run(const PoseGraph& graph, size_t true_edges) {
  const std::vector<size_t> loops = edges_out_of_order(graph);
  Run run{optimise(graph, loops, {})};
  for (const size_t loop : loops) {
    const bool is_accepted = run.result.edges[loop].outcome == LoopOutcome::kAccepted;
    run.true_rejected += loop < true_edges && !is_accepted;
    run.false_accepted += loop >= true_edges && is_accepted;
  }
  return run;
}

void expect_robust(const MadeGraph& made) {
  const std::vector<Pose> truth = true_poses(made);
  const PoseGraph graph = make_graph(made, truth);
  const Run clean = run(graph, graph.edges.size());
  EXPECT_LE(clean.true_rejected, made.loops / 20);
  for (const FalseLoopKind kind : {FalseLoopKind::kRandom, FalseLoopKind::kAlias}) {
    SCOPED_TRACE(kind == FalseLoopKind::kAlias ? "alias" : "random");
    const Run spoilt = run(with_false_loops(graph, {0.3, kind, made.seed}), graph.edges.size());
    EXPECT_EQ(spoilt.false_accepted, 0);
    EXPECT_LE(spoilt.true_rejected, made.loops / 20);
    EXPECT_LT(position_error(spoilt.result.T_world_node, truth),
              1.1 * position_error(clean.result.T_world_node, truth));
  }
}

TEST(RobustLoops, ThirdOfFalseLoopsChangesNothing) {
  for (const uint64_t seed : {1, 2, 3}) {
    SCOPED_TRACE(seed);
    expect_robust({.seed = seed});
  }
}

TEST(RobustLoops, InformationMayBeWrongByTen) {
  for (const double odometry : {0.1, 10.0}) {
    for (const double loops : {0.1, 10.0}) {
      SCOPED_TRACE(testing::Message() << "odometry " << odometry << " loops " << loops);
      expect_robust({.seed = 2, .odometry_factor = odometry, .loop_factor = loops});
    }
  }
}

TEST(RobustLoops, OdometryMayBelieveFarTooMuchOfItself) {
  expect_robust({.seed = 2, .odometry_factor = 100});
}

TEST(RobustLoops, DriftMayAccumulateSystematically) {
  expect_robust({.seed = 3, .bias_rad = 0.0005, .bias_m = 0.001});
}

/// Two stretches of one path as segments of their own, the second placed elsewhere; `count` loops join them.
PoseGraph two_segments(int count, bool are_in_conflict) {
  const MadeGraph made{.loops = 0};
  const std::vector<Pose> truth = true_poses(made);
  PoseGraph graph = make_graph(made, truth);
  graph.edges.erase(graph.edges.begin() + 149);
  const Pose T_away = exp_se3((Vector6d() << 0.5, 0, 1, 20, 0, 0).finished());
  for (int k = 150; k < 300; ++k) {
    graph.nodes[k].T_world_node = T_away * graph.nodes[k].T_world_node;
  }
  graph.nodes[150].is_fixed = true;
  for (int k = 0; k < count; ++k) {
    const int i = 40 + k, j = 240 + k;
    Pose T_i_j = truth[i].inverse(Eigen::Isometry) * truth[j];
    if (are_in_conflict) T_i_j.translation().x() += 3 * k;
    graph.edges.push_back({i, j, T_i_j, diagonal_information(0.005, 0.01)});
  }
  return graph;
}

TEST(RobustLoops, SegmentsAreJoinedByLoopsThatAgree) {
  const PoseGraph graph = two_segments(kLoopsToJoin, false);
  const OptimisedGraph result = run(graph, graph.edges.size()).result;
  EXPECT_EQ(result.components.anchor.size(), 1u);
  EXPECT_LT(position_error(result.T_world_node, true_poses({})), 0.3);
}

TEST(RobustLoops, SegmentsStayApartWhereTooFewLoopsAgree) {
  for (const PoseGraph& graph : {two_segments(kLoopsToJoin - 1, false), two_segments(3, true)}) {
    const OptimisedGraph result = run(graph, graph.edges.size()).result;
    ASSERT_EQ(result.components.anchor.size(), 2u);
    EXPECT_EQ(result.components.anchor[1], 150);
    EXPECT_EQ(result.edges.back().outcome, LoopOutcome::kUnconfirmed);
    EXPECT_TRUE(result.T_world_node[150].isApprox(graph.nodes[150].T_world_node, 1e-12));
  }
}

TEST(RobustLoops, DriftThatOnlyLoopsBetweenSegmentsShowIsNoFalseLoop) {
  // As of one mission in two logs that share a stretch and end where they began: more loops tell how the
  // second follows the first than how its end lies to the first's start, far away by optimistic odometry.
  const MadeGraph made{.loops = 0, .odometry_factor = 30, .bias_rad = 0.0005, .bias_m = 0.001};
  const std::vector<Pose> truth = true_poses(made);
  PoseGraph graph = make_graph(made, truth);
  graph.edges.erase(graph.edges.begin() + 149);
  for (int k = 0; k < 40; ++k) {
    const int i = k < 30 ? 145 - k : 3 * k - 90, j = k < 30 ? 155 + k : 110 + 3 * k;
    graph.edges.push_back(
        {i, j, truth[i].inverse(Eigen::Isometry) * truth[j], diagonal_information(0.005, 0.01)});
  }
  const auto [result, true_rejected, false_accepted] = run(graph, graph.edges.size());
  EXPECT_EQ(true_rejected, 0);
  EXPECT_GT(result.odometry_scale, 5);
  EXPECT_LT(position_error(result.T_world_node, truth), 0.2);
}

TEST(RobustLoops, OneLoneFalseLoopIsRejected) {
  const MadeGraph made{.loops = 0};
  PoseGraph graph = make_graph(made, true_poses(made));
  Pose T = Pose::Identity();
  T.translation().z() = 6;
  graph.edges.push_back({10, 250, T, diagonal_information(0.005, 0.01)});
  const OptimisedGraph result = optimise(graph, std::vector<size_t>{graph.edges.size() - 1}, {});
  EXPECT_EQ(result.edges.back().outcome, LoopOutcome::kAgainstOdometry);
  EXPECT_GT(result.edges.back().chi2_after, kGate);
  EXPECT_EQ(result.edges.back().weight, 0);
}

}  // namespace
}  // namespace kt
