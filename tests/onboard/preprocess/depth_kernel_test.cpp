// Tests of conversion, undistortion, bilateral filter and pyramid of depth.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/preprocess/depth_kernel.h"

#include <cmath>

#include "gtest/gtest.h"

#include "tests/onboard/preprocess/host_maps.h"

namespace kt::test {
namespace {

Calibration millimetres() {
  Calibration calibration = small_calibration();
  calibration.depth_unit_m = 0.001;
  return calibration;
}

TEST(ConvertDepth, ScalesAndKeepsTheTrustedRange) {
  const std::vector<int> raw{0, 1, 299, 301, 1234, 5999, 6001, 65535};
  const std::vector<float> expected_m{0, 0, 0, 0.301f, 1.234f, 5.999f, 0, 0};
  const Calibration calibration = millimetres();
  const HostMaps maps = preprocess(calibration, depth_frame(calibration.depth, [&](int u, int v) {
                                     return raw[static_cast<size_t>(u + v) % 8];
                                   }));
  for (int v = 0; v < 120; ++v) {
    for (int u = 0; u < 160; ++u)
      ASSERT_NEAR(maps.fusion(u, v).depth_m, expected_m[static_cast<size_t>(u + v) % 8], 1e-6f);
  }
}

TEST(ConvertDepth, DropsTheInvalidValue) {
  Calibration calibration = small_calibration();
  calibration.depth_unit_m = 5e-5;
  const RgbdFrame frame = depth_frame(calibration.depth, [](int u, int) { return u % 2 ? 65535 : 40000; });
  ASSERT_NEAR(preprocess(calibration, frame).fusion(81, 60).depth_m, 65535 * 5e-5,
              1e-6);  // a measurement like any other
  calibration.invalid_depth = 65535;
  EXPECT_EQ(preprocess(calibration, frame).fusion(81, 60).depth_m, 0);
  ASSERT_NEAR(preprocess(calibration, frame).fusion(80, 60).depth_m, 2.0, 1e-6);
}

Calibration distorted() {
  Calibration calibration = small_calibration();
  calibration.depth.distortion = {0.2624, -0.9531, -0.0054, 0.0026, 1.1633};
  return calibration;
}

// Each raw pixel carries its own number; where it ends up is compared with a slow inversion of the
// distortion.
TEST(Undistortion, TakesTheNearestRecordedPixel) {
  const Calibration calibration = distorted();
  const Camera& camera = calibration.depth;
  constexpr int kFirst = 10'000;  // 1 m
  const HostMaps maps = preprocess(
      calibration, depth_frame(camera, [&](int u, int v) { return kFirst + v * camera.width + u; }));
  int inside = 0;
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      const float z = maps.fusion(u, v).depth_m;
      if (z == 0) {
        const Eigen::Vector2d recorded = camera.project(
            ray_of_pixel(Camera{160, 120, camera.fx, camera.fy, camera.cx, camera.cy, {}}, u, v));
        EXPECT_TRUE(recorded.x() < -0.49 || recorded.y() < -0.49 || recorded.x() > 159.49 ||
                    recorded.y() > 119.49)
            << u << ' ' << v;
        continue;
      }
      ++inside;
      const int source = static_cast<int>(std::lround(z / 1e-4f)) - kFirst;
      const Eigen::Vector3d ray = ray_of_pixel(camera, source % camera.width, source / camera.width);
      EXPECT_LE(std::abs(camera.fx * ray.x() + camera.cx - u), 0.75) << u << ' ' << v;
      EXPECT_LE(std::abs(camera.fy * ray.y() + camera.cy - v), 0.75) << u << ' ' << v;
    }
  }
  EXPECT_GT(inside, 160 * 120 * 8 / 10);
}

TEST(Undistortion, StraightensATiltedWall) {
  const Calibration calibration = distorted();
  const Plane wall = tilted_wall(1.5, 15, 30);
  const HostMaps maps = preprocess(calibration, render(AnalyticScene({wall}), calibration, Pose::Identity()));
  const PinholeParams camera = calibration.depth.pinhole();
  for (int v = 0; v < 120; ++v) {
    for (int u = 0; u < 160; ++u) {
      const double expected = wall_depth(wall, camera, u, v);
      if (maps.fusion(u, v).depth_m == 0) continue;
      const double per_pixel = std::abs(wall_depth(wall, camera, u + 1, v) - expected) +
                               std::abs(wall_depth(wall, camera, u, v + 1) - expected);
      ASSERT_NEAR(maps.fusion(u, v).depth_m, expected, 0.8 * per_pixel + 1e-4) << u << ' ' << v;
    }
  }
}

TEST(BilateralFilter, KeepsAConstant) {
  const Calibration calibration = millimetres();
  const HostMaps maps =
      preprocess(calibration, depth_frame(calibration.depth, [](int, int) { return 1500; }));
  for (int v = 0; v < 120; ++v) {
    for (int u = 0; u < 160; ++u)
      ASSERT_NEAR(maps.levels[0].depth(u, v), 1.5f, 1e-6f) << "the rim must not pull values down";
  }
}

TEST(BilateralFilter, KeepsATiltedPlane) {
  const Calibration calibration = small_calibration();
  for (const auto& [about_x, about_y] : {std::pair{0.0, 30.0}, {40.0, 0.0}, {-20.0, -25.0}}) {
    const Plane wall = tilted_wall(1.5, about_x, about_y);
    const HostMaps maps =
        preprocess(calibration, render(AnalyticScene({wall}), calibration, Pose::Identity()));
    for (int v = 4; v < 116; ++v) {
      for (int u = 4; u < 156; ++u) {
        const float z = maps.levels[0].depth(u, v);
        if (z > 0) {
          ASSERT_NEAR(z, wall_depth(wall, maps.levels[0].camera, u, v), 5e-4) << u << ' ' << v;
        }
      }
    }
  }
}

TEST(BilateralFilter, KeepsADepthEdgeSharp) {
  const Calibration calibration = millimetres();
  const HostMaps maps = preprocess(
      calibration, depth_frame(calibration.depth, [](int u, int v) { return u + v / 3 < 90 ? 1500 : 1700; }));
  for (int v = 0; v < 120; ++v) {
    for (int u = 0; u < 160; ++u)
      ASSERT_NEAR(maps.levels[0].depth(u, v), u + v / 3 < 90 ? 1.5f : 1.7f, 1e-6f) << u << ' ' << v;
  }
}

TEST(BilateralFilter, TakesAwayMostOfTheNoise) {
  const Calibration calibration = small_calibration();
  const Plane wall{{0, 0, -1}, -2.0};
  const HostMaps maps = preprocess(calibration, render(AnalyticScene({wall}), calibration, Pose::Identity(),
                                                       {.noise_sigmas = 1, .seed = 4}));
  double before = 0, after = 0;
  for (int v = 3; v < 117; ++v) {
    for (int u = 3; u < 157; ++u) {
      before += std::pow(maps.fusion(u, v).depth_m - 2.0, 2);
      after += std::pow(maps.levels[0].depth(u, v) - 2.0, 2);
    }
  }
  EXPECT_GT(before / after, 6) << "ratio of variances";
}

TEST(BilateralFilter, NeverMixesInHoles) {
  const Calibration calibration = millimetres();
  const auto is_hole = [](int u, int v) { return (u * 7 + v * 13) % 5 == 0; };
  const RgbdFrame frame =
      depth_frame(calibration.depth, [&](int u, int v) { return is_hole(u, v) ? 0 : 1500; });
  const HostMaps maps = preprocess(calibration, frame);
  for (int v = 0; v < 120; ++v) {
    for (int u = 0; u < 160; ++u) ASSERT_NEAR(maps.levels[0].depth(u, v), is_hole(u, v) ? 0.0f : 1.5f, 1e-6f);
  }
}

// Where the range scale is as large as the depth itself.
TEST(BilateralFilter, NeverMixesInHolesOfFarSurfaces) {
  const Calibration calibration = millimetres();
  PreprocessConfig config;
  config.depth_max_m = 100;
  config.bilateral_range_sigmas = 20;
  const HostMaps maps =
      preprocess(calibration,
                 depth_frame(calibration.depth, [](int u, int) { return u % 5 == 0 ? 0 : 40'000; }), config);
  for (int u = 0; u < 160; ++u)
    ASSERT_NEAR(maps.levels[0].depth(u, 60), u % 5 == 0 ? 0.0f : 40.0f, 1e-4f) << u;
}

TEST(HalveDepth, AveragesOneSurfaceAndIgnoresHolesAndWhatLiesBehind) {
  const Calibration calibration = millimetres();
  // Quadruples of fine pixels, in millimetres, and what the coarse pixel must show.
  const struct {
    int raw[4];
    float expected_m;
  } cases[] = {{{1000, 1000, 1000, 1000}, 1.0f},  {{0, 0, 0, 0}, 0.0f},
               {{0, 1000, 0, 0}, 1.0f},           {{0, 1000, 1000, 0}, 1.0f},
               {{1000, 2000, 2000, 2000}, 1.0f},  {{3000, 2000, 0, 2000}, 2.0f},
               {{1000, 1040, 1000, 1040}, 1.02f}, {{1000, 1060, 1060, 1060}, 1.0f}};  // a slope, an edge
  const auto case_at = [&](int u, int v) { return cases[(u / 2 + v / 2) % 8]; };
  const HostMaps maps = preprocess(calibration, depth_frame(calibration.depth, [&](int u, int v) {
                                     return case_at(u, v).raw[u % 2 + 2 * (v % 2)];
                                   }));
  for (int v = 0; v < 60; ++v) {
    for (int u = 0; u < 80; ++u)
      ASSERT_NEAR(maps.levels[1].depth(u, v), case_at(2 * u, 2 * v).expected_m, 1e-6f) << u << ' ' << v;
  }
}

TEST(HalveDepth, LiesOnTheSamePlane) {
  const Calibration calibration = small_calibration(2);
  // Seen at a grazing angle, the pixels of a coarse one lie centimetres apart.
  for (const auto& [about_x_deg, about_y_deg] : {std::pair(10, -8), {0, 65}, {-68, 0}, {50, 50}}) {
    const Plane wall = tilted_wall(1.0, about_x_deg, about_y_deg);
    const HostMaps maps =
        preprocess(calibration, render(AnalyticScene({wall}), calibration, Pose::Identity()));
    for (size_t l = 1; l < maps.levels.size(); ++l) {
      const HostLevel& level = maps.levels[l];
      int compared = 0;
      for (int v = 2; v < level.camera.height - 2; ++v) {
        for (int u = 2; u < level.camera.width - 2; ++u) {
          const double z = wall_depth(wall, level.camera, u, v);
          if (z < 0.5 || z > 4) continue;
          ++compared;
          ASSERT_NEAR(level.depth(u, v), z, 2e-3 * z)
              << l << ", tilted " << about_x_deg << ' ' << about_y_deg;
        }
      }
      EXPECT_GT(compared, 200) << l << ", tilted " << about_x_deg << ' ' << about_y_deg;
    }
  }
}

}  // namespace
}  // namespace kt::test
