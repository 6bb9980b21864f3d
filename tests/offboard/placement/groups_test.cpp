// Which segments stand in one frame, which group is the main one, and what its graph holds.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/placement/groups.h"

#include "gmock/gmock.h"
#include "gtest/gtest.h"

#include "tests/shared/wire/sample_messages.h"

namespace kt {
namespace {

constexpr TrackingStatus kGood = TrackingStatus::kGood, kLost = TrackingStatus::kLost;

StampedPose pose_of(int64_t sequence, int segment, TrackingStatus status = kGood) {
  StampedPose pose = sample_stamped_pose(sequence);
  pose.segment = segment;
  pose.status = status;
  return pose;
}

// Poses where odometry has them, each group as given.
PlacedMission placed_as(const Session& session, std::vector<int> group) {
  PlacedMission placed;
  for (const StampedPose& pose : session.trajectory) placed.T_world_camera.push_back(pose.T_odom_camera);
  placed.group = std::move(group);
  placed.measured = mission_graph(session.trajectory, {});
  return placed;
}

size_t main_of(std::initializer_list<StampedPose> poses) {
  Session session;
  session.trajectory = poses;
  std::vector<int> group;
  for (const StampedPose& pose : poses) group.push_back(pose.segment);
  const PlacedMission placed = placed_as(session, group);
  return main_group(take_groups(session, placed));
}

TEST(Groups, TheMainOneHasTheMostGoodFramesOrIsTheEarliest) {
  EXPECT_EQ(main_of({pose_of(0, 0), pose_of(1, 1), pose_of(2, 1)}), 1u);
  EXPECT_EQ(main_of({pose_of(0, 0), pose_of(1, 1), pose_of(2, 1, kLost), pose_of(3, 1, kLost)}), 0u);
  EXPECT_EQ(main_of({pose_of(0, 7), pose_of(1, 3)}), 0u) << "the earliest is the one with the lowest number";
  Session session;
  session.slices = {SliceInfo::of(sample_slice())};
  session.slices[0].segment = 0;
  session.trajectory = {pose_of(0, 1, kLost)};
  const PlacedMission placed = placed_as(session, {1});
  EXPECT_EQ(main_group(take_groups(session, placed)), 1u) << "a segment without poses is no trajectory";
}

TEST(Groups, JoinedSegmentsAreOneAndOthersStayApart) {
  Session session;
  session.trajectory = {pose_of(0, 0), pose_of(1, 1), pose_of(2, 2), pose_of(3, 0)};
  session.slices = std::vector(2, SliceInfo::of(sample_slice()));
  session.slices[0].segment = 2;
  session.slices[1].segment = 9;  // its poses are lost
  PlacedMission placed = placed_as(session, {0, 1, 0, 0});
  placed.T_world_camera[2] = sample_pose(5);
  const std::vector<Group> groups = take_groups(session, placed);
  EXPECT_TRUE(session.trajectory.empty());
  ASSERT_EQ(groups.size(), 3u);
  EXPECT_EQ(groups[0].number(), 0);
  ASSERT_EQ(groups[0].segments.size(), 2u);
  EXPECT_EQ(groups[0].segments[1].number, 2);
  EXPECT_EQ(groups[0].segments[1].slices.size(), 1u);
  EXPECT_EQ(groups[1].number(), 1);
  EXPECT_EQ(groups[2].number(), 9);
  const Trajectory trajectory = groups[0].trajectory();
  ASSERT_EQ(trajectory.size(), 3u);
  EXPECT_EQ(trajectory[1].sequence, 2);
  EXPECT_EQ(trajectory[1].T_odom_camera.matrix(), sample_pose(5).matrix());
  EXPECT_EQ(groups[0].segments[1].trajectory[0].T_odom_camera.matrix(),
            sample_stamped_pose(2).T_odom_camera.matrix())
      << "as logged";
}

TEST(Groups, TheGraphHasTheGroupsPosesOnceFixedAndWhatIsBelieved) {
  Session session;
  session.trajectory = {pose_of(9, 0), pose_of(10, 0), pose_of(11, 1), pose_of(500, 2), pose_of(501, 2)};
  for (StampedPose& pose : session.trajectory) pose.from_sequence = pose.sequence - 1;
  PlacedMission placed = placed_as(session, {0, 0, 1, 0, 0});
  placed.measured =
      mission_graph(session.trajectory, std::vector{sample_loop(), sample_loop()});  // 10 to 500
  placed.solution.T_world_node = placed.T_world_camera;
  placed.solution.edges.resize(placed.measured.graph.edges.size());
  placed.solution.edges.back().weight = 0;
  const std::vector<Group> groups = take_groups(session, placed);
  ASSERT_EQ(groups.size(), 2u);
  const PoseGraph graph = graph_of(groups[0], placed);
  ASSERT_EQ(graph.nodes.size(), 4u);
  EXPECT_EQ(graph.nodes[2].id, 500);
  std::vector<bool> fixed;
  for (const PoseGraph::Node& node : graph.nodes) fixed.push_back(node.is_fixed);
  EXPECT_THAT(fixed, testing::ElementsAre(true, false, false, false));
  std::vector<std::pair<int64_t, int64_t>> edges;
  for (const PoseGraph::Edge& edge : graph.edges) edges.emplace_back(edge.from, edge.to);
  EXPECT_THAT(edges,
              testing::ElementsAre(testing::Pair(9, 10), testing::Pair(500, 501), testing::Pair(10, 500)));
  EXPECT_TRUE(graph_of(groups[1], placed).edges.empty());
}

}  // namespace
}  // namespace kt
