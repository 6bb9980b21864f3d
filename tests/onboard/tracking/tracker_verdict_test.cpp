// Tests of what the tracker says of a fit: lost, uncertain, how much was measured.
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "shared/core/rng.h"
#include "tests/onboard/tracking/tracker_trial.h"

namespace kt::test {
namespace {

TEST(Tracker, IsUncertainThenLostAsOverlapShrinks) {
  Trial trial;
  trial.model_columns = 160;
  EXPECT_EQ(trial.run().status, TrackingStatus::kGood);
  trial.model_columns = 18;  // 11 %, asked are 15 %
  EXPECT_EQ(trial.run().status, TrackingStatus::kUncertain);
  trial.model_columns = 6;
  EXPECT_EQ(trial.run().status, TrackingStatus::kLost);
  trial.model_columns = 0;
  EXPECT_EQ(trial.run().status, TrackingStatus::kLost);
}

TEST(Tracker, IsLostWhenTheCameraLooksElsewhere) {
  Trial trial;
  trial.T_odom_camera = trial.T_odom_guess = pose_of({0, 170, 0}, {0, 0, 0});
  EXPECT_EQ(trial.run().status, TrackingStatus::kLost);
}

TEST(Tracker, KnowsHowMuchAFrameMeasured) {
  const Calibration calibration = small_calibration();
  const exec::Device device = exec::Device::cpu(1);
  Preprocessor preprocessor(device, calibration, {});
  Tracker tracker(device, calibration, {});
  RgbdFrame frame = render(furnished_room(), calibration, Pose::Identity(), {});
  EXPECT_GT(tracker.measured_share(preprocessor.process(frame)), 0.9);
  for (int v = 0; v < 120; ++v) {
    for (int u = 80; u < 160; ++u) frame.depth(u, v) = 0;
  }
  EXPECT_NEAR(tracker.measured_share(preprocessor.process(frame)), 0.5, 0.05);
}

TEST(Tracker, KnowsHowMuchAFrameMeasuredFarAway) {
  const Calibration calibration = small_calibration();
  Preprocessor preprocessor(exec::Device::cpu(1), calibration, {});
  const AnalyticScene scene =
      AnalyticScene({Plane{{0, 0, -1}, -2.5}}).with(Box{{-3, -3, 0.5}, {-0.001, 3, 0.7}});  // the left half
  const FrameMaps& maps = preprocessor.process(render(scene, calibration, Pose::Identity()));
  EXPECT_GT(Tracker::measured_share(maps, 0.4), 0.9);
  EXPECT_NEAR(Tracker::measured_share(maps, 0.6), 0.5, 0.05);
  EXPECT_EQ(Tracker::measured_share(maps, 2.6), 0);
}

TEST(Tracker, DoesNotTakeNoiseForASurface) {
  const Calibration calibration = small_calibration();
  for (uint64_t seed = 0; seed < 3; ++seed) {
    RgbdFrame frame;
    frame.depth = Image<uint16_t>(160, 120);
    for (int64_t i = 0; i < frame.depth.pixel_count(); ++i) {
      frame.depth.data()[i] =
          static_cast<uint16_t>(5'000 + random_bits(seed, 0, static_cast<uint64_t>(i)) % 45'000);
    }
    EXPECT_NE(Trial().run(frame).status, TrackingStatus::kGood) << seed;
  }
}

TEST(Tracker, DoesNotTakeAnotherPlaceForThisOne) {
  Trial trial;
  const AnalyticScene other =
      AnalyticScene::room({-1.2, -2, -3}, {2.5, 0.8, 1.6}).with(Sphere{{-0.5, 0, 1.0}, 0.3});
  const TrackResult result = trial.run(render(other, small_calibration(), pose_of({0, 35, 0}, {0, 0, 0})));
  EXPECT_NE(result.status, TrackingStatus::kGood);
}

TEST(Tracker, IsLostWithoutMeasurements) {
  RgbdFrame frame;
  frame.depth = Image<uint16_t>(160, 120);
  Trial trial;
  trial.T_odom_guess = pose_of({0, 1, 0}, {0.01, 0, 0});
  const TrackResult result = trial.run(frame);
  EXPECT_EQ(result.status, TrackingStatus::kLost);
  EXPECT_TRUE(is_valid_pose(result.T_odom_camera));
  EXPECT_EQ(result.information, Matrix6d::Zero());
}

}  // namespace
}  // namespace kt::test
