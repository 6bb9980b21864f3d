// Tests of the deformation graph: where nodes stand, whom they neighbour and where they start.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/deformation/deformation_graph.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/offboard/deformation/made_paths.h"

namespace kt {
namespace {

using test::made_pose, test::stamped;
using testing::ElementsAre;

TEST(DeformationGraph, NodesStandApartAlongThePathAndWhereTheCameraLooks) {
  const std::vector<Pose> path = test::straight_path(200);
  const DeformationGraph graph = build_deformation_graph(test::trajectory_of(path), path);
  ASSERT_GT(graph.nodes.size(), 5u);
  EXPECT_EQ(graph.nodes[0].pose_sequence, 0);
  EXPECT_TRUE(graph.nodes[0].g_odom.isApprox(Eigen::Vector3d(0, 0, 1.5)));
  for (size_t i = 1; i < graph.nodes.size(); ++i) {
    const double apart_m = (graph.nodes[i].g_odom - graph.nodes[i - 1].g_odom).norm();
    EXPECT_GT(apart_m, graph.config.node_spacing_m);
    EXPECT_LE(apart_m, graph.config.node_spacing_m + test::kFrameStep_m + 1e-9);
  }
}

TEST(DeformationGraph, ATurnOnTheSpotHasNodesOnlyWhereTheyStandAheadOfTheCamera) {
  std::vector<Pose> path;
  for (int i = 0; i < 240; ++i) path.push_back(made_pose({0, 0.026 * i, 0}, {0, 0, 0}));
  DeformationConfig config;
  EXPECT_GT(build_deformation_graph(test::trajectory_of(path), path, config).nodes.size(), 15u);
  config.node_ahead_m = 0;
  EXPECT_EQ(build_deformation_graph(test::trajectory_of(path), path, config).nodes.size(), 1u);
}

TEST(DeformationGraph, NodesStartAtTheMotionOfTheirPoses) {
  const std::vector<Pose> after = test::straight_path(100);
  const Trajectory before = test::trajectory_of(test::arc_path(100, 0.1));
  const DeformationGraph graph = build_deformation_graph(before, after);
  const Eigen::Vector3d p_camera(0.3, -0.2, 2.0);
  for (const DeformationNode& node : graph.nodes) {
    const auto i = static_cast<size_t>(node.pose_sequence);
    EXPECT_LT((node.moved(before[i].T_odom_camera * p_camera) - after[i] * p_camera).norm(), 1e-12);
  }
  EXPECT_FALSE(graph.is_identity());
}

TEST(DeformationGraph, PosesThatDidNotChangeGiveExactIdentities) {
  const std::vector<Pose> path = test::arc_path(100, 0.3);
  EXPECT_TRUE(build_deformation_graph(test::trajectory_of(path), path).is_identity());
}

// The neighbours of node l.
std::vector<int> neighbours(const DeformationGraph& graph, int l) {
  std::vector<int> result;
  for (const auto& [node, neighbour] : graph.edges) {
    if (node == l) result.push_back(neighbour);
  }
  return result;
}

TEST(DeformationGraph, NeighboursAreNextInTimeAndTheEndsAreBlocks) {
  const std::vector<Pose> path = test::straight_path(22 * 9 + 1);
  DeformationConfig config;
  config.node_spacing_m = 0.43;
  const DeformationGraph graph = build_deformation_graph(test::trajectory_of(path), path, config);
  ASSERT_EQ(graph.nodes.size(), 10u);
  EXPECT_THAT(neighbours(graph, 0), ElementsAre(1, 2, 3, 4));
  EXPECT_THAT(neighbours(graph, 1), ElementsAre(0, 2, 3, 4));
  EXPECT_THAT(neighbours(graph, 2), ElementsAre(0, 1, 3, 4));
  EXPECT_THAT(neighbours(graph, 5), ElementsAre(3, 4, 6, 7));
  EXPECT_THAT(neighbours(graph, 8), ElementsAre(5, 6, 7, 9));
  EXPECT_THAT(neighbours(graph, 9), ElementsAre(5, 6, 7, 8));
}

TEST(DeformationGraph, FewNodesAreAllNeighbours) {
  const auto edges = [](int nodes) {
    const std::vector<Pose> path = test::straight_path(22 * (nodes - 1) + 1);
    return build_deformation_graph(test::trajectory_of(path), path).edges;
  };
  EXPECT_TRUE(edges(1).empty());
  EXPECT_THAT(edges(2), ElementsAre(std::array{0, 1}, std::array{1, 0}));
  EXPECT_EQ(edges(3).size(), 6u);
  EXPECT_EQ(edges(5).size(), 20u);
}

TEST(DeformationGraph, NoNodeStandsAtAPoseThatIsNotToBeBuiltOn) {
  std::vector<Pose> after = test::straight_path(6);
  for (Pose& pose : after) pose.translation() *= 100;
  Trajectory before = test::trajectory_of(after);
  before[0].status = TrackingStatus::kLost;
  before[1].status = TrackingStatus::kUncertain;
  before[3].T_odom_camera.translation().x() = test::kNan;
  after[4].linear() *= 2;
  const DeformationGraph graph = build_deformation_graph(before, after);
  ASSERT_EQ(graph.nodes.size(), 2u);
  EXPECT_EQ(graph.nodes[0].pose_sequence, 2);
  EXPECT_EQ(graph.nodes[1].pose_sequence, 5);
}

TEST(DeformationGraph, OfNoPosesHasNoNodesAndIsTheIdentity) {
  const DeformationGraph graph = build_deformation_graph({}, {});
  EXPECT_TRUE(graph.nodes.empty());
  EXPECT_TRUE(graph.edges.empty());
  EXPECT_TRUE(graph.is_identity());
}

}  // namespace
}  // namespace kt
