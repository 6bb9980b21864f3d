// Tests of the gains of whole missions whose true exposure is known.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/exposure/exposure_estimator.h"

#include <cmath>

#include "gtest/gtest.h"

#include "offboard/exposure/view_pairs.h"
#include "tests/offboard/exposure/exposed_frames.h"

namespace kt::test {
namespace {

constexpr int kFrames = 90;

// To and fro over the room: every place is seen several times.
Pose pose_at(int i) {
  const double phase = 0.14 * i;
  return pose_of({3 * std::cos(phase), 25 * std::sin(phase), 0},
                 {0.3 * std::sin(phase), 0, 0.1 * std::cos(phase)});
}

// A camera that follows the light, its white balance more slowly.
ChannelValues gain_at(int i) {
  const double all = 0.85 + 0.2 * std::sin(0.2 * i);
  return {all * (1 + 0.1 * std::sin(0.05 * i)), all, all * (1 - 0.1 * std::sin(0.07 * i))};
}

RgbdFrame frame_at(int i) {
  return render(furnished_room(), small_calibration(), pose_at(i),
                {.noise_sigmas = 1, .seed = 5, .texture_scale = 2, .sequence = i});
}

template <typename Gain>
FrameGains gains_of(const Gain& gain, const exec::Device& device = exec::Device::cpu(1)) {
  ExposureEstimator estimator(device, small_calibration(), {});
  for (int i = 0; i < kFrames; ++i) estimator.add(exposed(frame_at(i), gain(i)), pose_at(i));
  return estimator.finish();
}

TEST(ExposureEstimator, FindsTheGainsOfEveryFrame) {
  const FrameGains gains = gains_of(gain_at);
  EXPECT_TRUE(gains.figures.are_applied);
  EXPECT_GE(gains.figures.held_back, 3);
  EXPECT_LT(gains.figures.disagreement_after, 0.3 * gains.figures.disagreement_before);
  ASSERT_EQ(gains.log_gains.size(), static_cast<size_t>(kFrames));
  for (size_t c = 0; c < kColourChannels; ++c) {
    double mean = 0;  // the exposure of the whole mission is nobody's to know
    for (int i = 0; i < kFrames; ++i) mean += (gains.log_gains.at(i)[c] - std::log(gain_at(i)[c])) / kFrames;
    for (int i = 0; i < kFrames; ++i)
      EXPECT_NEAR(gains.log_gains.at(i)[c] - std::log(gain_at(i)[c]), mean, 0.02) << i << ' ' << c;
    EXPECT_LT(gains.figures.lowest_gain[c], 0.9);
    EXPECT_GT(gains.figures.highest_gain[c], 1.1);
  }
  const Vec3f factor = gains.factor(7);
  EXPECT_NEAR(factor.y, std::exp(-gains.log_gains.at(7)[1]), 1e-6);
  EXPECT_EQ(gains.factor(kFrames).y, 1) << "no such frame";
}

TEST(ExposureEstimator, LeavesAConstantExposureAlone) {
  const FrameGains gains = gains_of([](int) { return ChannelValues{0.9, 0.9, 0.9}; });
  EXPECT_FALSE(gains.figures.are_applied);
  EXPECT_EQ(gains.factor(7).x, 1);
  for (size_t c = 0; c < kColourChannels; ++c) {
    EXPECT_GT(gains.figures.lowest_gain[c], 0.98);
    EXPECT_LT(gains.figures.highest_gain[c], 1.02);
  }
}

TEST(ExposureEstimator, FramesThatShowNothingTakeTheGainBefore) {
  ExposureEstimator estimator(exec::Device::cpu(1), small_calibration(), {});
  RgbdFrame black = frame_at(0), without_colour = frame_at(2);
  for (Rgb8& colour : black.colour.pixels()) colour = {};
  without_colour.colour = {};
  estimator.add(black, pose_at(0));
  estimator.add(frame_at(1), pose_at(1));
  estimator.add(without_colour, pose_at(2));
  black.sequence = 3;
  estimator.add(black, pose_at(3));
  const FrameGains gains = estimator.finish();
  EXPECT_EQ(gains.figures.views, 1);
  ASSERT_EQ(gains.log_gains.size(), 2u)
      << "nothing is known before the first view, nor of a frame without colour";
  EXPECT_EQ(gains.log_gains.at(1), gains.log_gains.at(3));
  EXPECT_FALSE(gains.figures.are_applied) << "nothing was held back";
}

TEST(ExposureEstimator, ThreadsDoNotMatter) {
  const FrameGains one = gains_of(gain_at), three = gains_of(gain_at, exec::Device::cpu(3));
  EXPECT_EQ(one.log_gains, three.log_gains);
  EXPECT_EQ(one.figures.disagreement_after, three.figures.disagreement_after);
}

TEST(OverlappingViews, AreNeighboursAndRevisits) {
  std::vector<ExposureView> views;
  for (int k = 0; k < 12; ++k) {
    const Pose pose = pose_of({0, k < 6 ? 30.0 * k : 30.0 * (k - 6), 0}, {0, 0, 0});
    views.push_back(view_of(render(furnished_room(), small_calibration(), pose), pose));
  }
  std::vector<std::pair<size_t, size_t>> apart;
  for (const ViewPair& pair : overlapping_views(views)) {
    EXPECT_LT(pair.from, pair.to);
    if (pair.to - pair.from > 2) apart.emplace_back(pair.from, pair.to);
  }
  for (size_t k = 0; k < 6; ++k)
    EXPECT_TRUE(std::count(apart.begin(), apart.end(), std::pair(k, k + 6))) << k << " is seen again";
  for (const auto& [from, to] : apart) EXPECT_LE(from + 5, to) << "half a turn away";
}

}  // namespace
}  // namespace kt::test
