// The pose graph of a mission: its edges reproduce its poses.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/pose_graph/mission_graph.h"

#include <gtest/gtest.h>

#include "tests/shared/wire/sample_messages.h"

namespace kt {
namespace {

TEST(MissionGraph, ChainingTheEdgesGivesThePoses) {
  Trajectory poses;
  for (const int64_t sequence : {2, 3, 7, 8}) poses.push_back(sample_stamped_pose(sequence));
  poses[2].from_sequence = 3;
  const PoseGraph graph = mission_graph(poses, {}).graph;
  ASSERT_EQ(graph.nodes.size(), 4u);
  ASSERT_EQ(graph.edges.size(), 3u);
  Pose T_odom_camera = graph.nodes[0].T_world_node;
  for (size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(graph.edges[i].from, poses[i].sequence);
    EXPECT_EQ(graph.edges[i].to, poses[i + 1].sequence);
    EXPECT_EQ(graph.edges[i].information, poses[i + 1].information);
    T_odom_camera = T_odom_camera * graph.edges[i].T_from_to;
    EXPECT_TRUE(T_odom_camera.isApprox(poses[i + 1].T_odom_camera, 1e-12));
    EXPECT_EQ(graph.nodes[i].is_fixed, i == 0);
  }
}

TEST(MissionGraph, EdgesStartWhereThePoseWasMeasuredFrom) {
  Trajectory poses;
  for (const int64_t sequence : {2, 3, 4}) poses.push_back(sample_stamped_pose(sequence));
  poses[2].from_sequence = 2;  // 3 was doubtful
  const PoseGraph graph = mission_graph(poses, {}).graph;
  ASSERT_EQ(graph.edges.size(), 2u);
  EXPECT_EQ(graph.edges[1].from, 2);
  EXPECT_EQ(graph.edges[1].to, 4);
  const Pose T = poses[0].T_odom_camera * graph.edges[1].T_from_to;
  EXPECT_TRUE(T.isApprox(poses[2].T_odom_camera, 1e-12));
}

TEST(MissionGraph, FixesTheFirstGoodPose) {
  Trajectory poses;
  for (const int64_t sequence : {2, 3, 4}) poses.push_back(sample_stamped_pose(sequence));
  poses[0].status = poses[1].status = TrackingStatus::kLost;
  poses[2].status = TrackingStatus::kGood;
  const PoseGraph graph = mission_graph(poses, {}).graph;
  ASSERT_EQ(graph.nodes.size(), 3u);
  EXPECT_FALSE(graph.nodes[0].is_fixed);
  EXPECT_FALSE(graph.nodes[1].is_fixed);
  EXPECT_TRUE(graph.nodes[2].is_fixed);
}

TEST(MissionGraph, SegmentsHangTogetherByLoopsOnly) {
  Trajectory poses;
  for (const int64_t sequence : {9, 10, 11, 500, 501}) poses.push_back(sample_stamped_pose(sequence));
  for (StampedPose& pose : poses) pose.segment = pose.sequence >= 500;
  poses[3].from_sequence = 11;  // it cannot be
  const MissionGraph mission = mission_graph(poses, std::vector{sample_loop()});
  ASSERT_EQ(mission.graph.edges.size(), 4u);
  EXPECT_EQ(mission.graph.edges[2].from, 500);
  EXPECT_EQ(mission.graph.edges[3].from, 10);
  EXPECT_TRUE(mission.graph.nodes[0].is_fixed);
  EXPECT_TRUE(mission.graph.nodes[3].is_fixed);
}

TEST(MissionGraph, AnEdgeFromAPoseThatIsNotThereBeginsAtTheOneBefore) {
  Trajectory poses;
  for (const int64_t sequence : {2, 3, 4, 5, 6}) poses.push_back(sample_stamped_pose(sequence));
  poses[0].from_sequence = 2;  // begins the segment
  poses[2].from_sequence = 1;  // lost by the log, or of another segment
  poses[3].from_sequence = 9;  // later: nonsense
  const PoseGraph graph = mission_graph(poses, {}).graph;
  EXPECT_EQ(graph.nodes.size(), 5u);
  ASSERT_EQ(graph.edges.size(), 4u);
  for (size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(graph.edges[i].from, poses[i].sequence);
    EXPECT_EQ(graph.edges[i].to, poses[i + 1].sequence);
    const bool is_bridge = i == 1 || i == 2;
    EXPECT_EQ(graph.edges[i].information, Matrix6d(poses[i + 1].information / (is_bridge ? 2.0 : 1.0))) << i;
    EXPECT_TRUE(
        (poses[i].T_odom_camera * graph.edges[i].T_from_to).isApprox(poses[i + 1].T_odom_camera, 1e-12));
  }
}

TEST(MissionGraph, TakesAcceptedLoopsBetweenPosesThatAreThere) {
  Trajectory poses;
  for (const int64_t sequence : {10, 11, 500}) poses.push_back(sample_stamped_pose(sequence));
  const LoopClosure rejected = sample_loop(LoopVerdict::kWeak);
  LoopClosure dangling = sample_loop();
  dangling.to = 499;
  const MissionGraph mission = mission_graph(poses, std::vector{rejected, sample_loop(), dangling});
  const PoseGraph& graph = mission.graph;
  EXPECT_EQ(mission.loop_edges, std::vector<size_t>{2});
  EXPECT_EQ(mission.loops, std::vector<size_t>{1});
  ASSERT_EQ(graph.edges.size(), 3u);
  EXPECT_EQ(graph.edges[2].from, 10);
  EXPECT_EQ(graph.edges[2].to, 500);
  EXPECT_EQ(graph.edges[2].T_from_to.matrix(), sample_loop().T_from_to.matrix());
}

}  // namespace
}  // namespace kt
