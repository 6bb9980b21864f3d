// Tests of corridors and other hard stretches with the help of texture, wheels and a gyroscope, or without.
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <functional>
#include <gtest/gtest.h>
#include <numbers>
#include <utility>

#include "tests/onboard/app/recovery_scene.h"

namespace kt::test {
namespace {

// Endless along z; a ball at its beginning shows how fast a camera comes in.
Place corridor(double contrast) {
  const AnalyticScene scene({Plane{{1, 0, 0}, -0.8}, Plane{{-1, 0, 0}, -0.9}, Plane{{0, -1, 0}, -1.0},
                             Plane{{0, 1, 0}, -1.3}, Sphere{{0.6, 0.5, 0.9}, 0.3}});
  return {scene, 3, contrast, 0};
}

// Walls at grazing angles are modelled badly, which pulls along the corridor.
CollectorConfig short_sighted_config() {
  CollectorConfig config = recovery_config();
  config.preprocess.depth_max_m = 3;
  return config;
}

// A camera that goes into the corridor and wags.
Pose walked(double time_s) { return pose_of({0, 2 * std::sin(time_s), 0}, {0, 0, 0.5 * time_s}); }

double time_s(int64_t stamp) { return static_cast<double>(stamp - stamp_us(0)) * 1e-6; }

TEST(CarriedRecovery, ABareCorridorIsNotFusedForLong) {
  const Place bare = corridor(0);
  Mission mission(kFine, short_sighted_config());
  mission.tolerance_deg = 3;
  // What it walks in max_unconstrained_s, and slips before while noise now and then seems to hold it.
  mission.tolerance_m = 0.3;
  int64_t first_free = -1, last_good = -1;
  for (int tick = 0; tick < 60; ++tick) {
    const StampedPose& pose = mission.see(bare, walked(time_s(stamp_us(tick))), tick);
    if (pose.status == TrackingStatus::kGood) {
      EXPECT_EQ(last_good, tick - 1) << "good again";
      last_good = tick;
      if (pose.quality.free_directions == 0) first_free = -1;
      if (pose.quality.free_directions > 0 && first_free < 0) first_free = tick;
    } else {
      EXPECT_EQ(pose.status, TrackingStatus::kUncertain) << tick;
      EXPECT_EQ(pose.cause, TrackingCause::kUnconstrained) << tick;
    }
  }
  mission.collector.finish();
  EXPECT_GT(first_free, 1);
  EXPECT_NEAR(static_cast<double>(last_good - first_free), 30 * TrackingConfig{}.max_unconstrained_s, 2);
  for (const CloudSlice& slice : mission.sink.slices) {
    for (const SliceVertex& vertex : slice.vertices) ASSERT_LE(vertex.pose_sequence, last_good);
  }
}

TEST(CarriedRecovery, TextureHoldsACorridor) {
  const Place textured = corridor(1);
  Mission mission(kFine, short_sighted_config());
  mission.tolerance_m = 0.03;
  for (int tick = 0; tick < 60; tick += 2)
    EXPECT_EQ(mission.see(textured, walked(time_s(stamp_us(tick))), tick).status, TrackingStatus::kGood)
        << tick;
}

// Odometry of wheels, 50 Hz: `scale` times too long, and drifting about the vertical.
class Wheels {
 public:
  explicit Wheels(std::function<Pose(double time_s)> path, double scale = 1.02)
      : path_(std::move(path)), scale_(scale) {}
  double rotation_sigma = 0.01, translation_sigma = 0.02;

  // All samples that come before the frame of this tick.
  void roll(int64_t tick, Collector* collector) {
    for (; next_us_ <= stamp_us(tick); next_us_ += 20'000) {
      constexpr double kDrift_rps = 0.002;
      const Pose T = path_(time_s(next_us_));
      MotionSample sample;
      sample.sequence = sequence_++;
      sample.timestamp_us = next_us_;
      sample.T_prior.linear() = exp_so3({0, kDrift_rps * time_s(next_us_), 0}) * T.linear();
      sample.T_prior.translation() =
          scale_ * (exp_so3({0, kDrift_rps * time_s(next_us_), 0}) * T.translation());
      sample.rotation_sigma = rotation_sigma;
      sample.translation_sigma = translation_sigma;
      ASSERT_TRUE(collector->add_motion_sample(sample));
    }
  }

 private:
  std::function<Pose(double time_s)> path_;
  double scale_;
  int64_t next_us_ = stamp_us(0) - 10'000, sequence_ = 0;
};

TEST(CarriedRecovery, WheelsCarryThroughABareCorridor) {
  const Place bare = corridor(0);
  Mission mission(kFine, short_sighted_config());
  Wheels wheels(walked);
  for (int tick = 0; tick < 180; tick += 3) {
    wheels.roll(tick, &mission.collector);
    const double now_s = time_s(stamp_us(tick));
    mission.tolerance_deg = 1;
    mission.tolerance_m = std::max(0.02, 0.03 * 0.5 * now_s);
    EXPECT_EQ(mission.see(bare, walked(now_s), tick).status, TrackingStatus::kGood) << tick;
  }
}

TEST(CarriedRecovery, WheelsThatAreWrongDoNotSpoilATexturedRoom) {
  Mission mission;
  mission.tolerance_m = 0.01;
  const auto path = [](double s) { return pose_of({0, 3 * std::sin(s), 0}, {0.2 * s, 0, 0.3 * s}); };
  Wheels wheels(path, 2);
  for (int tick = 0; tick < 60; tick += 2) {
    wheels.roll(tick, &mission.collector);
    EXPECT_EQ(mission.see(home(), path(time_s(stamp_us(tick))), tick).status, TrackingStatus::kGood) << tick;
  }
}

TEST(CarriedRecovery, WheelsCarryThroughABlackout) {
  Mission mission(kCoarse);
  const auto path = [](double s) { return pose_of({0, 20 * s, 0}, {0.3 * s, 0, 0.1 * s}); };
  Wheels wheels(path);
  for (int tick = 0; tick < 38; ++tick) {
    wheels.roll(tick, &mission.collector);
    const Pose T_world_camera = path(time_s(stamp_us(tick)));
    if (tick < 5 || tick >= 35) {
      EXPECT_EQ(mission.see(home(), T_world_camera, tick).status, TrackingStatus::kGood) << tick;
      continue;
    }
    const StampedPose& pose = mission.see_nothing(tick);
    EXPECT_EQ(pose.status, TrackingStatus::kUncertain);
    EXPECT_EQ(pose.source, PoseSource::kPrior);
    EXPECT_EQ(pose.cause, TrackingCause::kNoDepth);
    ASSERT_EQ(pose.from_sequence, 4);
    const Pose T_from_to = mission.sink.poses[4].T_odom_camera.inverse() * pose.T_odom_camera,
               truth = path(time_s(stamp_us(4))).inverse() * T_world_camera;
    const Vector6d error = log_se3(T_from_to * truth.inverse());
    EXPECT_LT(error.dot(pose.information * error), 6) << "no more certain than right";
    const double black_s = time_s(stamp_us(tick)) - time_s(stamp_us(4));
    const Matrix6d covariance = pose.information.inverse();
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_NEAR(std::sqrt(covariance(axis, axis)), wheels.rotation_sigma * std::sqrt(black_s), 1e-4);
      EXPECT_NEAR(std::sqrt(covariance(3 + axis, 3 + axis)), wheels.translation_sigma * std::sqrt(black_s),
                  2e-3);
    }
  }
}

TEST(CarriedRecovery, AGyroscopeFollowsATurnThatDepthAloneCannot) {
  for (const bool has_gyroscope : {false, true}) {
    Mission mission(kCoarse);
    double yaw_deg = 0;
    int tick = 0, good = 0;
    for (const double step_deg : {0, 0, 30, 30, 0, 0}) {
      if (has_gyroscope) {
        MotionSample sample;
        sample.timestamp_us = stamp_us(tick - 2);
        sample.kind = MotionSample::Kind::kVelocity;
        sample.velocity[1] = step_deg * std::numbers::pi / 180 / time_s(stamp_us(2));
        sample.rotation_sigma = 0.002;
        ASSERT_TRUE(mission.collector.add_motion_sample(sample));
      }
      yaw_deg += step_deg;
      RgbdFrame frame = photograph(home(), kCoarse, turned(yaw_deg), tick);
      frame.colour = {};
      good += mission.take(frame, &home(), turned(yaw_deg)).status == TrackingStatus::kGood;
      tick += 2;
    }
    if (has_gyroscope)
      EXPECT_EQ(good, 6);
    else
      EXPECT_LT(good, 6) << "an easy turn proves nothing";
  }
}

}  // namespace
}  // namespace kt::test
