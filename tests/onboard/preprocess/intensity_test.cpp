// Tests of the intensity pyramid: levels, lens, look-up and its derivative.
// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <vector>

#include "gtest/gtest.h"

#include "onboard/preprocess/intensity_pyramid.h"
#include "shared/core/rng.h"
#include "tests/support/analytic_scene.h"
#include "tests/support/devices.h"

namespace kt::test {
namespace {

struct Pyramid {
  std::array<std::vector<float>, kIntensityLevels> levels;
  std::array<PinholeParams, kIntensityLevels> cameras;
};

Pyramid pyramid_of(const Camera& camera, const Image<Rgb8>& image, const exec::Device& device = {}) {
  exec::Buffer<Rgb8> colour(device, image.pixel_count());
  colour.upload(image.pixels());
  IntensityPyramid pyramid(device, camera);
  pyramid.build(colour.data());
  Pyramid result;
  for (int l = 0; l < kIntensityLevels; ++l) {
    result.levels[static_cast<size_t>(l)] = pyramid.level(l).levels.downloaded();
    result.cameras[static_cast<size_t>(l)] = pyramid.level(l).camera;
  }
  return result;
}

double luma(const Eigen::Vector3d& c) { return 0.299 * c.x() + 0.587 * c.y() + 0.114 * c.z(); }

// Every level against the colour of the wall that its pixel sees; returns how many pixels show something.
int compare_with_wall(const Calibration& calibration) {
  const AnalyticScene wall({Plane{Eigen::Vector3d(0.2, -0.1, -1).normalized(), -1.5}});
  const Pyramid pyramid = pyramid_of(calibration.colour, render(wall, calibration, Pose::Identity()).colour);
  int shown = 0;
  for (size_t l = 0; l < kIntensityLevels; ++l) {
    const PinholeParams& camera = pyramid.cameras[l];
    for (int v = 0; v < camera.height; ++v) {
      for (int u = 0; u < camera.width; ++u) {
        const float level = pyramid.levels[l][static_cast<size_t>(v * camera.width + u)];
        if (level < 0) continue;
        ++shown;
        const auto hit = wall.trace(Eigen::Vector3d::Zero(),
                                    {(u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, 1});
        EXPECT_NEAR(level, luma(AnalyticScene::colour(hit->p_world)), 1.5)
            << "level " << l << ": " << u << ' ' << v;
      }
    }
  }
  return shown;
}

TEST(IntensityPyramid, ShowsWhatItsCamerasSee) {
  EXPECT_EQ(compare_with_wall(small_calibration()), 80 * 60 + 40 * 30 + 20 * 15);
}

TEST(IntensityPyramid, TakesTheLensOut) {
  Calibration calibration = small_calibration();
  calibration.colour.distortion = {0.26, -0.95, -0.005, 0.003, 1.16};
  EXPECT_GT(compare_with_wall(calibration), 0.8 * (80 * 60 + 40 * 30 + 20 * 15));
}

TEST(IntensityPyramid, GivesTheSameBitsOnEveryDevice) {
  Calibration calibration = small_calibration();
  calibration.colour.distortion = {0.26, -0.95, -0.005, 0.003, 1.16};
  const Image<Rgb8> image = render(furnished_room(), calibration, Pose::Identity()).colour;
  const Pyramid reference = pyramid_of(calibration.colour, image);
  for (const exec::Device& device : parity_devices())
    EXPECT_EQ(pyramid_of(calibration.colour, image, device).levels, reference.levels) << name_of(device);
}

TEST(IntensityView, SamplesBilinearlyWithTheExactDerivative) {
  std::vector<float> levels;
  for (uint64_t i = 0; i < 12 * 9; ++i) levels.push_back(static_cast<float>(255 * random_uniform(1, 2, i)));
  const IntensityView view{levels.data(), 12, 9};
  for (uint64_t i = 0; i < 200; ++i) {
    // Well inside a cell, where the bilinear surface is smooth.
    const auto cell = [&](uint64_t stream, int cells) {
      return static_cast<float>(random_bits(3, stream, i) % static_cast<uint64_t>(cells)) +
             static_cast<float>(0.1 + 0.8 * random_uniform(4, stream, i));
    };
    const float u = cell(0, 11), v = cell(1, 8);
    float at, by_u, by_v, ahead = 0, behind = 0, unused;
    ASSERT_TRUE(view.sample(u, v, &at, &by_u, &by_v));
    constexpr float kStep = 0.03f;
    view.sample(u + kStep, v, &ahead, &unused, &unused);
    view.sample(u - kStep, v, &behind, &unused, &unused);
    EXPECT_NEAR(by_u, (ahead - behind) / (2 * kStep), 0.02);
    view.sample(u, v + kStep, &ahead, &unused, &unused);
    view.sample(u, v - kStep, &behind, &unused, &unused);
    EXPECT_NEAR(by_v, (ahead - behind) / (2 * kStep), 0.02);
  }
}

TEST(IntensityView, KnowsWhereItShowsNothing) {
  std::vector<float> levels(5 * 4, 100.0f);
  levels[1 * 5 + 2] = -1;
  const IntensityView view{levels.data(), 5, 4};
  float at, by_u, by_v;
  EXPECT_TRUE(view.sample(0.0f, 0.5f, &at, &by_u, &by_v));
  for (const auto& [u, v] : {std::pair(-0.1f, 1.0f),
                             {4.0f, 1.0f},
                             {1.0f, 3.0f},
                             {1.0f, -0.1f},
                             {NAN, 1.0f},
                             {1.5f, 0.5f},
                             {2.5f, 1.5f}})
    EXPECT_FALSE(view.sample(u, v, &at, &by_u, &by_v)) << u << ' ' << v;
}

}  // namespace
}  // namespace kt::test
