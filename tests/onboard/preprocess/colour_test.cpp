// Tests of the registration of colour to depth.
// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include "gtest/gtest.h"

#include "tests/onboard/preprocess/host_maps.h"

namespace kt::test {
namespace {

struct Rgba {
  double r, g, b;
  int a;
};
Rgba unpack(uint32_t rgba) {
  return {static_cast<double>(rgba & 255), static_cast<double>(rgba >> 8 & 255),
          static_cast<double>(rgba >> 16 & 255), static_cast<int>(rgba >> 24)};
}

// Every coloured pixel against the texture at its point; returns how many there are.
int compare_with_texture(const Calibration& calibration, const Plane& wall) {
  const HostMaps maps = preprocess(calibration, render(AnalyticScene({wall}), calibration, Pose::Identity()));
  const PinholeParams camera = calibration.depth.pinhole();
  int coloured = 0;
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      const Rgba seen = unpack(maps.rgba(u, v));
      const Eigen::Vector3d p = wall_depth(wall, camera, u, v) *
                                Eigen::Vector3d((u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, 1);
      const Eigen::Vector2d pixel = calibration.colour.project(calibration.T_colour_depth * p);
      const bool inside = pixel.x() > 0.01 && pixel.y() > 0.01 &&
                          pixel.x() < calibration.colour.width - 1.01 &&
                          pixel.y() < calibration.colour.height - 1.01;
      const bool outside = pixel.x() < -0.01 || pixel.y() < -0.01 ||
                           pixel.x() > calibration.colour.width - 0.99 ||
                           pixel.y() > calibration.colour.height - 0.99;
      if (inside) {
        EXPECT_EQ(seen.a, 255) << u << ' ' << v;
      }
      if (outside) {
        EXPECT_EQ(seen.a, 0) << u << ' ' << v;
      }
      if (seen.a == 0) continue;
      ++coloured;
      const Eigen::Vector3d expected = AnalyticScene::colour(p);
      EXPECT_NEAR(seen.r, expected.x(), 2) << u << ' ' << v;
      EXPECT_NEAR(seen.g, expected.y(), 2) << u << ' ' << v;
      EXPECT_NEAR(seen.b, expected.z(), 2) << u << ' ' << v;
    }
  }
  return coloured;
}

TEST(RegisteredColour, OfARegisteredCameraIsThePixelItself) {
  const Calibration calibration = small_calibration();
  EXPECT_GT(compare_with_texture(calibration, tilted_wall(1.5, 10, 20)), 158 * 118 - 1);
}

TEST(RegisteredColour, FollowsAnOffsetColourCamera) {
  Calibration calibration = small_calibration();
  calibration.colour = {200, 150, 190, 188, 101, 73, {0.05, -0.1, 0.001, -0.002, 0.02}};
  calibration.T_colour_depth = pose_of({1.0, -2.0, 0.5}, {0.05, -0.01, 0.004});
  for (const double distance : {0.6, 1.5, 3.0}) {
    EXPECT_GT(compare_with_texture(calibration, tilted_wall(distance, -15, 10)), 10'000) << distance;
  }
}

TEST(RegisteredColour, DependsOnTheRangeOfANearSurface) {
  Calibration calibration = small_calibration();
  calibration.T_colour_depth = pose_of({0, 0, 0}, {0.05, 0, 0});
  // 5 cm to the side are 8 pixels at 0.8 m and 2 at 3.2 m: a registration by a fixed shift would show.
  EXPECT_GT(compare_with_texture(calibration, tilted_wall(0.8, 0, 0)), 10'000);
  EXPECT_GT(compare_with_texture(calibration, tilted_wall(3.2, 0, 0)), 10'000);
}

TEST(RegisteredColour, IsMissingWhereDepthIs) {
  const Calibration calibration = small_calibration();
  RgbdFrame frame = render(AnalyticScene({tilted_wall(1.5, 0, 0)}), calibration, Pose::Identity());
  for (int u = 0; u < 160; ++u) frame.depth(u, 60) = 0;
  const HostMaps maps = preprocess(calibration, frame);
  for (int u = 1; u < 158; ++u) {
    EXPECT_EQ(maps.rgba(u, 60), 0u);
    EXPECT_NE(maps.rgba(u, 50), 0u);
  }
}

TEST(RegisteredColour, WithoutAColourImageThereIsNone) {
  const Calibration calibration = small_calibration();
  RgbdFrame frame = render(AnalyticScene({tilted_wall(1.5, 0, 0)}), calibration, Pose::Identity());
  Preprocessor preprocessor(exec::Device::cpu(1), calibration, {});
  preprocessor.process(frame);  // with colour: nothing of it may remain
  frame.colour = {};
  const HostMaps maps(preprocessor.process(frame));
  EXPECT_TRUE(maps.colours.empty());
}

}  // namespace
}  // namespace kt::test
