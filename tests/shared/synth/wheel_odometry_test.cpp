// The drift of the made odometry against the figures that it states, and its repeatability.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/synth/wheel_odometry.h"

#include <cmath>
#include <gtest/gtest.h>

namespace kt {
namespace {

constexpr WheelFlaws kNone{.scale_error = 0, .yaw_drift_rps = 0, .rotation_sigma = 0, .translation_sigma = 0};

TEST(WheelOdometry, WithoutFlawsItIsThePathFromItsStart) {
  const SyntheticMission mission("ring", {.frames = 91, .downscale = 8});
  const std::vector<MotionSample> samples = wheel_odometry(mission, kNone);
  const Trajectory& truth = mission.groundtruth();
  ASSERT_EQ(samples.size(), 151u);  // 3 s at 50 Hz
  EXPECT_EQ(samples.front().timestamp_us, truth.front().timestamp_us);
  EXPECT_EQ(samples.back().timestamp_us, truth.back().timestamp_us);
  for (size_t i = 0; i < samples.size(); i += 5) {  // every third frame has a sample's stamp
    const StampedPose& pose = truth[i * 3 / 5];
    ASSERT_EQ(samples[i].timestamp_us, pose.timestamp_us);
    EXPECT_EQ(samples[i].sequence, static_cast<int64_t>(i));
    EXPECT_EQ(samples[i].kind, MotionSample::Kind::kPose);
    EXPECT_TRUE(
        samples[i].T_prior.isApprox(truth.front().T_odom_camera.inverse() * pose.T_odom_camera, 1e-9));
  }
}

TEST(WheelOdometry, TheSystematicPartIsAScaleAndAYaw) {
  const SyntheticMission mission("ring");
  const auto length = [](const std::vector<MotionSample>& samples) {
    double sum = 0;
    for (size_t i = 1; i < samples.size(); ++i)
      sum += (samples[i - 1].T_prior.inverse() * samples[i].T_prior).translation().norm();
    return sum;
  };
  WheelFlaws flaws = kNone;
  const auto exact = wheel_odometry(mission, flaws);
  flaws.scale_error = 0.02;
  EXPECT_NEAR(length(wheel_odometry(mission, flaws)) / length(exact), 1.02, 1e-9);
  flaws.yaw_drift_rps = 0.002;
  const auto drifted = wheel_odometry(mission, flaws);
  const Pose start = mission.groundtruth().front().T_odom_camera;
  const Eigen::Matrix3d turn = start.linear() * drifted.back().T_prior.linear() *
                               exact.back().T_prior.linear().transpose() * start.linear().transpose();
  const double duration_s =
      static_cast<double>(exact.back().timestamp_us - exact.front().timestamp_us) * 1e-6;
  EXPECT_LT((log_so3(turn) - Eigen::Vector3d(0, 0, 0.002 * duration_s)).norm(), 1e-9);
}

TEST(WheelOdometry, TheNoiseGrowsAsItsSigmasSay) {
  const SyntheticMission mission("apartment");  // 75 s
  const WheelFlaws flaws{.scale_error = 0, .yaw_drift_rps = 0};
  const auto samples = wheel_odometry(mission, flaws), exact = wheel_odometry(mission, kNone);
  ASSERT_GT(samples.size(), 3000u);
  for (const size_t stride : {1, 25}) {
    double rotation = 0, translation = 0;
    int count = 0;
    for (size_t i = stride; i < samples.size(); i += stride, ++count) {
      const Pose measured = samples[i - stride].T_prior.inverse() * samples[i].T_prior;
      const Pose truth = exact[i - stride].T_prior.inverse() * exact[i].T_prior;
      const Vector6d error = log_se3(truth.inverse() * measured);
      rotation += error.head<3>().squaredNorm();
      translation += error.tail<3>().squaredNorm();
    }
    const double axes_and_seconds = 3 * count * 0.02 * static_cast<double>(stride);
    EXPECT_EQ(samples[0].rotation_sigma, flaws.rotation_sigma);
    EXPECT_EQ(samples[0].translation_sigma, flaws.translation_sigma);
    EXPECT_NEAR(std::sqrt(rotation / axes_and_seconds) / flaws.rotation_sigma, 1, 0.1) << stride;
    EXPECT_NEAR(std::sqrt(translation / axes_and_seconds) / flaws.translation_sigma, 1, 0.1) << stride;
  }
}

TEST(WheelOdometry, IsTheSameEveryTimeAndAnotherForAnotherMission) {
  const auto first = [](const char* name) {
    return wheel_odometry(SyntheticMission(name, {.frames = 31, .downscale = 8}));
  };
  const auto a = first("room"), b = first("room"), c = first("room-plain");  // on the same path
  ASSERT_EQ(a.size(), b.size());
  EXPECT_EQ(a.back().T_prior.matrix(), b.back().T_prior.matrix());
  EXPECT_NE(a.back().T_prior.matrix(), c.back().T_prior.matrix());
}

TEST(WheelOdometry, FewerFramesOnlyCutItShort) {
  const auto few = wheel_odometry(SyntheticMission("room", {.frames = 31}));
  const auto all = wheel_odometry(SyntheticMission("room"));
  ASSERT_EQ(few.size(), 51u);
  EXPECT_EQ(few.back().T_prior.matrix(), all[50].T_prior.matrix());
}

}  // namespace
}  // namespace kt
