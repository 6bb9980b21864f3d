// The body that carries the camera: where, when, how fast.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/types/body_pose.h"

#include <gtest/gtest.h>

namespace kt {
namespace {

// A camera half a metre in front of the middle of a robot that looks along x; z of the camera is x of the
// body.
Calibration on_a_robot() {
  Calibration calibration;
  calibration.stamp_delay_s = 0.01;
  calibration.T_body_camera.linear() << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  calibration.T_body_camera.translation() = Eigen::Vector3d(0.5, 0, 0.2);
  return calibration;
}

// As the tracker would see a body there.
StampedPose pose_of(const Pose& T_odom_body, int64_t timestamp_us) {
  StampedPose pose;
  pose.sequence = timestamp_us / 1000;
  pose.timestamp_us = timestamp_us;
  pose.T_odom_camera = T_odom_body * on_a_robot().T_body_camera;
  return pose;
}

Pose turned(double yaw, double x_m) {
  Pose T = Pose::Identity();
  T.rotate(Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()));
  T.translation().x() = x_m;
  return T;
}

TEST(BodyPose, IsWhereTheBodyIsAndWhen) {
  const BodyPose body = body_pose(pose_of(turned(0.3, 2), 1'000'000), nullptr, on_a_robot());
  EXPECT_TRUE(body.T_odom_body.isApprox(turned(0.3, 2), 1e-12));
  EXPECT_EQ(body.timestamp_us, 990'000);
  EXPECT_EQ(body.sequence, 1000);
  EXPECT_EQ(body.velocity, Vector6d::Zero());
}

TEST(BodyPose, ARobotThatTurnsOnTheSpotMovesNowhereThoughItsCameraDoes) {
  const StampedPose before = pose_of(turned(0, 1), 0), after = pose_of(turned(0.05, 1), 100'000);
  EXPECT_GT((after.T_odom_camera.translation() - before.T_odom_camera.translation()).norm(), 0.02);
  Vector6d expected = Vector6d::Zero();
  expected[2] = 0.5;  // rad/s about z
  EXPECT_TRUE(body_pose(after, &before, on_a_robot()).velocity.isApprox(expected, 1e-9));
}

TEST(BodyPose, ARobotThatDrivesStraightHasSpeedAlongItsX) {
  const StampedPose before = pose_of(turned(0.4, 0), 0);
  const StampedPose after = pose_of(turned(0.4, 0) * turned(0, 0.1), 100'000);
  Vector6d expected = Vector6d::Zero();
  expected[3] = 1;
  EXPECT_TRUE(body_pose(after, &before, on_a_robot()).velocity.isApprox(expected, 1e-9));
}

TEST(BodyPose, HasNoVelocityAcrossALossOrASegment) {
  const StampedPose before = pose_of(turned(0, 0), 0);
  StampedPose after = pose_of(turned(0, 0.1), 100'000);
  after.segment = 1;
  EXPECT_EQ(body_pose(after, &before, on_a_robot()).velocity, Vector6d::Zero());
  EXPECT_EQ(body_pose(after, &before, on_a_robot()).segment, 1);
  after.segment = 0;
  after.status = TrackingStatus::kLost;
  EXPECT_EQ(body_pose(after, &before, on_a_robot()).velocity, Vector6d::Zero());
  EXPECT_EQ(body_pose(after, &before, on_a_robot()).status, TrackingStatus::kLost);
}

}  // namespace
}  // namespace kt
