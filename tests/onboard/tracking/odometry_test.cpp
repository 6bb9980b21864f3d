// Tests of what the odometry makes of another sensor's motion.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/tracking/odometry.h"

#include <numbers>

#include "gtest/gtest.h"

#include "tests/onboard/tracking/model_views.h"
#include "tests/support/pose_matchers.h"

namespace kt::test {
namespace {

// A robot drives in an arc towards a bare wall. The wall tells how the camera turns and how near it is,
// wheels without a gyroscope how far it goes: along its own changing direction.
TEST(Odometry, AVelocityWithoutRotationFollowsTheTurnOfTheCamera) {
  const exec::Device device = exec::Device::cpu(1);
  const Calibration calibration = small_calibration();
  const AnalyticScene wall({Plane{{0, 0, -1}, -2}});
  Preprocessor preprocessor(device, calibration, {});
  Odometry odometry(device, calibration, {});
  constexpr double kInterval_s = 33'333e-6;
  Vector6d twist = Vector6d::Zero();
  twist(1) = 4 * std::numbers::pi / 180 / kInterval_s;
  twist(5) = 0.04 / kInterval_s;
  ModelView view;
  const auto predict = [&](const Pose& T_odom_camera) -> const ModelView& {
    view = exact_model_view(device, wall, calibration.depth.pinhole().half(), T_odom_camera);
    return view;
  };
  Pose T_odom_last = Pose::Identity();
  for (int64_t sequence = 0; sequence < 6; ++sequence) {
    const Pose truth = exp_se3(static_cast<double>(sequence) * kInterval_s * twist);
    RgbdFrame frame = render(wall, calibration, truth, {.sequence = sequence});
    frame.colour = {};
    MotionSample sample;
    sample.sequence = sequence;
    sample.timestamp_us = frame.timestamp_us;
    sample.kind = MotionSample::Kind::kVelocity;
    sample.velocity.tail<3>() = twist.tail<3>();
    sample.translation_sigma = 0.005;
    EXPECT_TRUE(odometry.add_motion_sample(sample));
    const FrameMaps& maps = preprocessor.process(frame);
    const StampedPose pose = odometry.track(maps, sequence == 0 ? nullptr : &view, predict, {}, sequence);
    ASSERT_EQ(pose.status, TrackingStatus::kGood) << sequence;
    const Pose T_last_current = T_odom_last.inverse() * pose.T_odom_camera;
    if (sequence >= 2) {  // by then it is known how the camera turns
      EXPECT_POSE_NEAR(T_last_current, exp_se3(kInterval_s * twist), 0.1, 4e-4);
    }
    T_odom_last = pose.T_odom_camera;
    odometry.remember(maps, &predict(pose.T_odom_camera));
  }
}

// The same robot with its camera on a body that has x forward and z up: the odom frame is where the body was
// first, and the wheels speak of the body.
TEST(Odometry, OfACameraOnABodyBeginsWhereTheBodyIs) {
  const exec::Device device = exec::Device::cpu(1);
  Calibration calibration = small_calibration();
  calibration.T_body_camera.linear() << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  calibration.T_body_camera.translation() = Eigen::Vector3d(0.2, 0.05, 0.9);
  const AnalyticScene wall({Plane{{-1, 0, 0}, -2.2}});
  Preprocessor preprocessor(device, calibration, {});
  Odometry odometry(device, calibration, {});
  constexpr double kInterval_s = 33'333e-6;
  MotionSample wheels;
  wheels.kind = MotionSample::Kind::kVelocity;
  wheels.of = MotionSample::Of::kBody;
  wheels.velocity(2) = 4 * std::numbers::pi / 180 / kInterval_s;
  wheels.velocity(3) = 0.04 / kInterval_s;
  wheels.rotation_sigma = wheels.translation_sigma = 0.005;
  ModelView view;
  const auto predict = [&](const Pose& T_odom_camera) -> const ModelView& {
    view = exact_model_view(device, wall, calibration.depth.pinhole().half(), T_odom_camera);
    return view;
  };
  for (int64_t sequence = 0; sequence < 6; ++sequence) {
    const Pose T_odom_body = exp_se3(static_cast<double>(sequence) * kInterval_s * wheels.velocity),
               truth = T_odom_body * calibration.T_body_camera;
    RgbdFrame frame = render(wall, calibration, truth, {.sequence = sequence});
    frame.colour = {};
    wheels.sequence = sequence;
    wheels.timestamp_us = frame.timestamp_us;
    EXPECT_TRUE(odometry.add_motion_sample(of_camera(wheels, calibration.T_body_camera)));
    const FrameMaps& maps = preprocessor.process(frame);
    const StampedPose pose = odometry.track(maps, sequence == 0 ? nullptr : &view, predict, {}, sequence);
    ASSERT_EQ(pose.status, TrackingStatus::kGood) << sequence;
    EXPECT_POSE_NEAR(pose.T_odom_camera, truth, 0.2, 2e-3);
    odometry.remember(maps, &predict(pose.T_odom_camera));
  }
}

}  // namespace
}  // namespace kt::test
