// Motion and covariance along a tree, against a slow walk and against drawn noise.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/pose_graph/odometry_forest.h"

#include <gtest/gtest.h>

#include "offboard/pose_graph/loop_consistency.h"
#include "tests/offboard/pose_graph/made_graphs.h"

namespace kt {
namespace {

TEST(OdometryForest, CovarianceAddsUpAlongThePath) {
  const MadeGraph made{.nodes = 60, .loops = 0};
  const std::vector<Pose> truth = true_poses(made);
  const IndexedGraph graph = indexed(make_graph(made, truth));
  const OdometryForest forest(graph, odometry_only(graph));
  const OdometryForest::Motion motion = forest.between(13, 51);
  Pose T = Pose::Identity();
  Matrix6d covariance = Matrix6d::Zero();
  for (int k = 13; k < 51; ++k) {
    const Matrix6d Ad = adjoint(T);
    covariance += Ad * diagonal_information(1 / made.odometry_rad, 1 / made.odometry_m) * Ad.transpose();
    T = T * graph.edges[k].T_from_to;
  }
  EXPECT_TRUE(motion.T_from_to.isApprox(T, 1e-9));
  EXPECT_LT((motion.covariance - covariance).norm(), 1e-9 * covariance.norm());
  const OdometryForest::Motion back = forest.between(51, 13);
  const Matrix6d Ad = adjoint(back.T_from_to);
  EXPECT_LT((back.covariance - Ad * covariance * Ad.transpose()).norm(), 1e-9 * back.covariance.norm());
}

TEST(OdometryForest, BranchesMeetAtTheirCommonAncestor) {
  // 0 - 1 - 2, and 3 hangs on 1 by an edge that starts at 3; 4 is alone.
  PoseGraph graph;
  for (int k = 0; k < 5; ++k) graph.nodes.push_back({k, Pose::Identity(), false});
  Pose step = Pose::Identity();
  step.translation() = Eigen::Vector3d(1, 0.5, 0);
  for (const auto& [from, to] : {std::pair{0, 1}, {1, 2}, {3, 1}}) {
    graph.edges.push_back({from, to, step, Matrix6d::Identity()});
  }
  const IndexedGraph ready = indexed(graph);
  const OdometryForest forest(ready, odometry_only(ready));
  EXPECT_EQ(forest.tree(3), forest.tree(0));
  EXPECT_NE(forest.tree(4), forest.tree(0));
  const OdometryForest::Motion motion = forest.between(3, 2);
  EXPECT_TRUE(motion.T_from_to.isApprox(step * step, 1e-12));
  const Matrix6d Ad = adjoint(step);
  EXPECT_LT((motion.covariance - Matrix6d::Identity() - Ad * Ad.transpose()).norm(), 1e-12);
}

TEST(LoopConsistency, SquaresOfHonestNoiseAreChiSquares) {
  double loops = 0, cycles = 0;
  int count = 0;
  for (uint64_t seed = 1; seed <= 8; ++seed) {
    const MadeGraph made{.loops = 20, .seed = seed};
    const PoseGraph graph = make_graph(made, true_poses(made));
    const IndexedGraph ready = indexed(graph, edges_out_of_order(graph));
    const OdometryForest forest(ready, odometry_only(ready));
    for (size_t e = ready.edges.size() - 20; e + 1 < ready.edges.size(); ++e, ++count) {
      loops += squared_sigmas(ready.edges[e], forest.between(ready.edges[e].from, ready.edges[e].to));
      cycles += cycle_squared_sigmas(forest, ready.edges[e], ready.edges[e + 1]);
    }
  }
  EXPECT_NEAR(loops / count, 6, 2);
  EXPECT_NEAR(cycles / count, 6, 2);
}

TEST(LoopConsistency, ScalesFollowTheInformation) {
  for (const double factor : {0.3, 1.0, 10.0, 100.0, 300.0}) {
    SCOPED_TRACE(factor);
    const MadeGraph made{.odometry_factor = factor};
    const PoseGraph graph = make_graph(made, true_poses(made));
    const IndexedGraph ready = indexed(graph, edges_out_of_order(graph));
    const double scale = measured_odometry_scale(ready, OdometryForest(ready, odometry_only(ready)));
    // All loops look at one and the same drift, which may be a lucky or an unlucky one.
    EXPECT_GT(scale, factor / 4);
    EXPECT_LT(scale, factor * 4);
  }
}

}  // namespace
}  // namespace kt
