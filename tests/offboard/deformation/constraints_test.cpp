// Tests of what a deformation has to reach: points of the poses and of loop closures.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/deformation/constraints.h"

#include <gtest/gtest.h>

#include "tests/offboard/deformation/made_paths.h"

namespace kt {
namespace {

TEST(CameraConstraints, WithoutLengthsAreTheCameraPositions) {
  const std::vector<Pose> after = test::straight_path(10);
  const Trajectory before = test::trajectory_of(test::arc_path(10, 0.1));
  DeformationConfig config;
  config.node_ahead_m = config.camera_arm_m = 0;
  const auto constraints = camera_constraints(before, after, config);
  ASSERT_EQ(constraints.size(), 10u);
  for (size_t i = 0; i < 10; ++i) {
    EXPECT_EQ(constraints[i].p_odom, before[i].T_odom_camera.translation());
    EXPECT_EQ(constraints[i].p_world, after[i].translation());
    EXPECT_EQ(constraints[i].pose_sequence, before[i].sequence);
    EXPECT_FALSE(constraints[i].is_surface);
  }
}

TEST(CameraConstraints, WithLengthsSurroundTheViewCentre) {
  const Trajectory before = {test::stamped(7, Pose::Identity())};
  const std::vector<Pose> after = {test::made_pose({0, 0, 0}, {10, 0, 0})};
  const auto constraints = camera_constraints(before, after, {});
  ASSERT_EQ(constraints.size(), 4u);
  EXPECT_EQ(constraints[0].p_odom, Eigen::Vector3d(0, 0, 1.5));
  EXPECT_EQ(constraints[1].p_odom, Eigen::Vector3d(1, 0, 1.5));
  EXPECT_EQ(constraints[2].p_odom, Eigen::Vector3d(0, 1, 1.5));
  EXPECT_EQ(constraints[3].p_odom, Eigen::Vector3d(0, 0, 2.5));
  EXPECT_EQ(constraints[3].p_world, Eigen::Vector3d(10, 0, 2.5));
}

TEST(CameraConstraints, LeaveOutPosesThatAreNotToBeBuiltOn) {
  std::vector<Pose> after = test::straight_path(4);
  Trajectory before = test::trajectory_of(after);
  before[1].status = TrackingStatus::kLost;
  after[2].translation().x() = test::kNan;
  EXPECT_EQ(camera_constraints(before, after, {}).size(), 8u);
}

LoopClosure made_loop(int64_t from, int64_t to) {
  LoopClosure loop;
  loop.from = from, loop.to = to;
  loop.p_from = {{0, 0, 1}, {0.5f, 0, 2}};
  loop.p_to = {{0, 0.5f, 1}, {0.5f, 0.5f, 2}};
  return loop;
}

TEST(SurfaceConstraints, BringBothSightingsToTheirMiddle) {
  const Trajectory before = {test::stamped(3, test::made_pose({0, 0, 0}, {0, 0, 0})),
                             test::stamped(9, test::made_pose({0, 0, 0}, {1, 0, 0}))};
  const std::vector<Pose> after = {Pose::Identity(), test::made_pose({0, 0, 0}, {0.5, 0, 0})};
  const auto constraints = surface_constraints(before, after, std::vector{made_loop(3, 9)});
  ASSERT_EQ(constraints.size(), 4u);
  EXPECT_EQ(constraints[0].p_odom, Eigen::Vector3d(0, 0, 1));
  EXPECT_EQ(constraints[0].pose_sequence, 3);
  EXPECT_EQ(constraints[1].p_odom, Eigen::Vector3d(1, 0.5, 1));
  EXPECT_EQ(constraints[1].pose_sequence, 9);
  for (size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(constraints[i].p_world, Eigen::Vector3d(0.25, 0.25, 1));
    EXPECT_TRUE(constraints[i].is_surface);
  }
}

TEST(SurfaceConstraints, LeaveOutMissingFramesAndPointsThatAreNotFinite) {
  const Trajectory before = test::trajectory_of(test::straight_path(5));
  const std::vector<Pose> after = test::straight_path(5);
  LoopClosure half = made_loop(0, 4);
  half.p_to[0].y = std::numeric_limits<float>::infinity();
  LoopClosure uneven = made_loop(0, 4);
  uneven.p_from.pop_back();
  EXPECT_TRUE(surface_constraints(before, after, std::vector{made_loop(0, 5), made_loop(-1, 3)}).empty());
  EXPECT_EQ(surface_constraints(before, after, std::vector{half}).size(), 2u);
  EXPECT_EQ(surface_constraints(before, after, std::vector{uneven}).size(), 2u);
}

}  // namespace
}  // namespace kt
