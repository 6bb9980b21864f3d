// Tests of the names of the tracking states.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/types/stamped_pose.h"

#include "gtest/gtest.h"

namespace kt {
namespace {

TEST(TrackingStatus, HasAName) {
  EXPECT_STREQ(to_string(TrackingStatus::kGood), "good");
  EXPECT_STREQ(to_string(TrackingStatus::kUncertain), "uncertain");
  EXPECT_STREQ(to_string(TrackingStatus::kLost), "lost");
  EXPECT_STREQ(to_string(static_cast<TrackingStatus>(17)), "unknown");  // as a damaged log may hold
}

TEST(PoseSource, HasAName) {
  EXPECT_STREQ(to_string(PoseSource::kNone), "none");
  EXPECT_STREQ(to_string(PoseSource::kModel), "model");
  EXPECT_STREQ(to_string(PoseSource::kPrior), "prior");
  EXPECT_STREQ(to_string(static_cast<PoseSource>(kPoseSources)), "unknown");
}

TEST(TrackingCause, HasAName) {
  EXPECT_STREQ(to_string(TrackingCause::kNone), "none");
  EXPECT_STREQ(to_string(TrackingCause::kFewInliers), "few inliers");
  EXPECT_STREQ(to_string(TrackingCause::kUnconfirmed), "unconfirmed");
  EXPECT_STREQ(to_string(TrackingCause::kNoFrames), "no frames");
  EXPECT_STREQ(to_string(static_cast<TrackingCause>(kTrackingCauses)), "unknown");
}

StampedPose pose_at(int64_t timestamp_us, double x_m, int segment = 0) {
  StampedPose pose;
  pose.timestamp_us = timestamp_us;
  pose.T_odom_camera.translation().x() = x_m;
  pose.segment = segment;
  return pose;
}

std::vector<double> x_of(const Trajectory& trajectory) {
  std::vector<double> x;
  for (const StampedPose& pose : trajectory) x.push_back(pose.T_odom_camera.translation().x());
  return x;
}

TEST(AtStamps, MovesPosesToWhereTheCameraWasThen) {
  // 1 m/s, then 3 m/s; nothing is known between the segments, and nothing across the second of silence.
  const Trajectory measured{pose_at(0, 0), pose_at(100'000, 0.1), pose_at(200'000, 0.4),
                            pose_at(300'000, 5, 1), pose_at(1'300'000, 6, 1)};
  const auto late = x_of(at_stamps(measured, 0.01)), early = x_of(at_stamps(measured, -0.01));
  const std::vector<double> expected_late{0.01, 0.13, 0.43, 5, 6}, expected_early{-0.01, 0.09, 0.37, 5, 6};
  for (size_t i = 0; i < measured.size(); ++i) {
    EXPECT_NEAR(late[i], expected_late[i], 1e-12) << i;
    EXPECT_NEAR(early[i], expected_early[i], 1e-12) << i;
  }
  EXPECT_EQ(x_of(at_stamps(measured, 0)), x_of(measured));
}

TEST(Velocities, AreTheMeanOfTheMotionsAround) {
  const Trajectory trajectory{pose_at(0, 0), pose_at(100'000, 0.1), pose_at(200'000, 0.4),
                              pose_at(300'000, 5, 1)};
  const std::vector<double> expected{1, 2, 3, 0};
  const std::vector<Vector6d> found = velocities(trajectory);
  for (size_t i = 0; i < expected.size(); ++i) EXPECT_NEAR(found.at(i)(3), expected[i], 1e-12) << i;
}

TEST(AtStamps, DoesNotTrustPosesThatAreRepeated) {
  Trajectory measured{pose_at(0, 0), pose_at(100'000, 0.1), pose_at(200'000, 0.1)};
  measured[2].status = TrackingStatus::kLost;
  EXPECT_NEAR(x_of(at_stamps(measured, 0.01))[1], 0.11, 1e-12);
}

}  // namespace
}  // namespace kt
