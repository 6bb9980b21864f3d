// Tests of what views at low resolution show of each other.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/exposure/exposure_view.h"

#include "gtest/gtest.h"

#include "tests/offboard/exposure/exposed_frames.h"

namespace kt::test {
namespace {

const Pose kHere = Pose::Identity(), kAside = pose_of({2, 12, 1}, {-0.3, 0.1, 0.2});

RgbdFrame seen_from(const Pose& T_world_camera, const AnalyticScene& scene = furnished_room()) {
  return render(scene, small_calibration(), T_world_camera);
}

double middle(std::vector<float> values) {
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2),
                   values.end());
  return static_cast<double>(values[values.size() / 2]);
}

TEST(ExposureView, CellsHoldDepthAndTheLogarithmOfTheMeanLevel) {
  const RgbdFrame frame = seen_from(kHere);
  const ExposureView view = view_of(frame, kHere);
  ASSERT_EQ(view.camera.width, 80);
  ASSERT_EQ(view.camera.height, 60);
  const double z_m = 1e-4 * frame.depth(81, 61), sum = frame.colour(80, 60).g + frame.colour(81, 60).g +
                                                       frame.colour(80, 61).g + frame.colour(81, 61).g;
  EXPECT_NEAR(view.at(40, 30).depth_m, z_m, 1e-4);
  EXPECT_NEAR(view.at(40, 30).log_levels[1], std::log(sum / 4), 1e-5);
}

TEST(ExposureView, RatiosAreThoseOfTheGains) {
  const ChannelValues gain{0.8, 1.0, 0.7};
  const ExposureView a = view_of(seen_from(kHere), kHere),
                     b = view_of(exposed(seen_from(kAside), gain), kAside);
  const LogRatios there = log_ratios(a, b), back = log_ratios(b, a);
  for (size_t c = 0; c < kColourChannels; ++c) {
    ASSERT_GT(there[c].size(), 1000u);
    EXPECT_NEAR(middle(there[c]), std::log(gain[c]), 0.004) << c;
    EXPECT_NEAR(middle(back[c]), -std::log(gain[c]), 0.004) << c;
  }
}

TEST(ExposureView, ClippedAndDarkCellsSayNothing) {
  RgbdFrame frame = seen_from(kHere);
  for (Rgb8& colour : frame.colour.pixels()) colour = {100, 59, 251};
  frame.colour(40, 40).r = 255;
  const ExposureView view = view_of(frame, kHere);
  EXPECT_EQ(view.at(20, 20).log_levels[0], ExposureCell::kUnusable) << "one clipped pixel";
  EXPECT_NEAR(view.at(40, 30).log_levels[0], std::log(100.0), 1e-5);
  EXPECT_EQ(view.at(40, 30).log_levels[1], ExposureCell::kUnusable);
  EXPECT_EQ(view.at(40, 30).log_levels[2], ExposureCell::kUnusable);
  EXPECT_TRUE(log_ratios(view, view)[1].empty());
}

TEST(ExposureView, WhatIsHiddenIsNotCompared) {
  const AnalyticScene screened = furnished_room().with(Box{{-5, -5, 0.8}, {0, 5, 0.85}});
  const ExposureView free = view_of(seen_from(kHere), kHere),
                     hidden = view_of(seen_from(kHere, screened), kHere);
  EXPECT_NEAR(overlap(free, hidden, 2), 0.5, 0.1) << "the left half is behind the screen";
  EXPECT_NEAR(overlap(free, free, 2), 1, 0.1);
  const LogRatios ratios = log_ratios(free, hidden);
  EXPECT_GT(ratios[0].size(), 1000u);
  for (const float ratio : ratios[0]) EXPECT_NEAR(ratio, 0, 1e-3) << "not those of the screen";
}

TEST(ExposureView, ObliqueSurfacesAreLeftOut) {
  const Calibration calibration = small_calibration();
  const auto cells_on = [&](double tilt_deg) {
    const Eigen::Vector3d n = pose_of({tilt_deg, 0, 0}, {0, 0, 0}).linear() * Eigen::Vector3d(0, 0, -1);
    const ExposureView view =
        view_of(render(AnalyticScene({Plane{n, -1 * std::abs(n.z())}}), calibration, kHere), kHere);
    return view.at(40, 30).depth_m > 0;
  };
  EXPECT_TRUE(cells_on(60));
  EXPECT_FALSE(cells_on(76));
}

}  // namespace
}  // namespace kt::test
