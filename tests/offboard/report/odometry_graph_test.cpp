// The pose graph of a session: its edges reproduce its poses.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/report/odometry_graph.h"

#include <gtest/gtest.h>

#include "tests/shared/wire/sample_messages.h"

namespace kt {
namespace {

TEST(OdometryGraph, ChainingTheEdgesGivesThePoses) {
  Session session;
  for (const int64_t sequence : {2, 3, 7, 8}) session.trajectory.push_back(sample_stamped_pose(sequence));
  const PoseGraph graph = odometry_graph(session);
  ASSERT_EQ(graph.nodes.size(), 4u);
  ASSERT_EQ(graph.edges.size(), 3u);
  Pose T_odom_camera = graph.nodes[0].T_world_node;
  for (size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(graph.edges[i].from, session.trajectory[i].sequence);
    EXPECT_EQ(graph.edges[i].to, session.trajectory[i + 1].sequence);
    EXPECT_EQ(graph.edges[i].information, session.trajectory[i + 1].information);
    T_odom_camera = T_odom_camera * graph.edges[i].T_from_to;
    EXPECT_TRUE(T_odom_camera.isApprox(session.trajectory[i + 1].T_odom_camera, 1e-12));
    EXPECT_EQ(graph.nodes[i].is_fixed, i == 0);
  }
}

TEST(OdometryGraph, EdgesStartWhereThePoseWasMeasuredFrom) {
  Session session;
  for (const int64_t sequence : {2, 3, 4, 5}) session.trajectory.push_back(sample_stamped_pose(sequence));
  session.trajectory[2].from_sequence = 2;  // 3 was doubtful
  session.trajectory[3].from_sequence = 1;  // a pose that the log has lost
  const PoseGraph graph = odometry_graph(session);
  ASSERT_EQ(graph.edges.size(), 3u);
  EXPECT_EQ(graph.edges[1].from, 2);
  EXPECT_EQ(graph.edges[1].to, 4);
  const Pose T = session.trajectory[0].T_odom_camera * graph.edges[1].T_from_to;
  EXPECT_TRUE(T.isApprox(session.trajectory[2].T_odom_camera, 1e-12));
  EXPECT_EQ(graph.edges[2].from, 4) << "the one before stands in";
}

TEST(OdometryGraph, TakesAcceptedLoopsBetweenPosesThatAreThere) {
  Session session;
  for (const int64_t sequence : {10, 11, 500}) session.trajectory.push_back(sample_stamped_pose(sequence));
  LoopClosure rejected = sample_loop(), dangling = sample_loop();
  rejected.accepted = false;
  dangling.to = 499;
  session.loop_closures = {rejected, sample_loop(), dangling};
  const PoseGraph graph = odometry_graph(session);
  ASSERT_EQ(graph.edges.size(), 3u);
  EXPECT_EQ(graph.edges[2].from, 10);
  EXPECT_EQ(graph.edges[2].to, 500);
  EXPECT_EQ(graph.edges[2].T_from_to.matrix(), sample_loop().T_from_to.matrix());
}

}  // namespace
}  // namespace kt
