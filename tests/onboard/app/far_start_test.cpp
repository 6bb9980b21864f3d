// Test of missions that begin far from everything.
// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <vector>

#include "gtest/gtest.h"

#include "onboard/app/collector.h"
#include "tests/onboard/app/recording_sink.h"
#include "tests/support/pose_matchers.h"

namespace kt::test {
namespace {

// What one frame fuses of a far wall is too rough to fit the next frame to.
TEST(FarStart, IsGoodFromTheFirstFramesOn) {
  CollectorConfig config;
  config.volume.resolution = 512;
  config.volume.voxel_size_m = 0.01;
  RecordingSink sink;
  const Calibration calibration = small_calibration(2);
  Collector collector(exec::Device::cpu(1), calibration, config, sink);
  const AnalyticScene scene = AnalyticScene::room({-2.5, -1.5, -1}, {2, 1.5, 3.5});
  const auto pose_at = [](int frame) {
    const double t = 0.15 * frame;
    return pose_of({3 * std::sin(t), 8 * std::sin(0.7 * t), 2 * std::sin(1.3 * t)},
                   {0.25 * std::sin(0.8 * t), 0.1 * std::sin(t), 0.3 * std::sin(0.5 * t)});
  };
  std::vector<PoseSource> sources;
  for (int i = 0; i < 28; ++i) {
    const RgbdFrame frame =
        render(scene, calibration, pose_at(i), {.noise_sigmas = 1, .seed = 1, .sequence = i});
    const FrameReport report = collector.process(frame);
    ASSERT_EQ(report.pose.status, TrackingStatus::kGood) << i;
    EXPECT_POSE_NEAR(report.pose.T_odom_camera, pose_at(0).inverse() * pose_at(i), 0.3, 0.02);
    sources.push_back(report.pose.source);
  }
  EXPECT_EQ(sources[1], PoseSource::kPairwise) << "nothing is tested otherwise";
  EXPECT_EQ(sources.back(), PoseSource::kModel);
}

}  // namespace
}  // namespace kt::test
