// Tests of projection with distortion and of the sanity check of intrinsics.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/geometry/camera.h"

#include <cmath>
#include <functional>
#include <limits>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace kt {
namespace {

using testing::HasSubstr;

const Camera kFreiburg1{
    640, 480, 517.306, 516.469, 318.643, 255.314, {0.2624, -0.9531, -0.0054, 0.0026, 1.1633}};

TEST(Camera, ProjectsToKnownPixels) {
  // Brown-Conrady with rational numbers, rounded once.
  const struct {
    Eigen::Vector3d p;
    double u, v;
  } known[] = {{{0, 0, 1}, 318.643, 255.314},
               {{0.3, -0.2, 1}, 477.777765320, 149.149626036},
               {{-0.9, 0.7, 2}, 82.003840881, 438.501914283},
               {{1.1, 0.8, 1.9}, 630.562892673, 479.868083891}};
  for (const auto& [p, u, v] : known) {
    EXPECT_NEAR(kFreiburg1.project(p).x(), u, 1e-8);
    EXPECT_NEAR(kFreiburg1.project(p).y(), v, 1e-8);
  }
}

// The radial part in polar coordinates: it scales the angle's tangent and keeps the direction.
TEST(Camera, RadialDistortionScalesTheRadius) {
  Camera camera = kFreiburg1;
  camera.distortion = {0.1, -0.2, 0, 0, 0.05};
  for (double radius = 0.05; radius < 0.9; radius += 0.1) {
    for (double angle = 0; angle < 6; angle += 0.7) {
      const Eigen::Vector2d pixel = camera.project({radius * std::cos(angle), radius * std::sin(angle), 1});
      const double scaled =
          radius + 0.1 * std::pow(radius, 3) - 0.2 * std::pow(radius, 5) + 0.05 * std::pow(radius, 7);
      EXPECT_NEAR(pixel.x(), camera.cx + camera.fx * scaled * std::cos(angle), 1e-9);
      EXPECT_NEAR(pixel.y(), camera.cy + camera.fy * scaled * std::sin(angle), 1e-9);
    }
  }
}

TEST(Camera, DependsOnTheRayAlone) {
  const Eigen::Vector3d ray(0.21, -0.34, 1);
  EXPECT_LT((kFreiburg1.project(ray) - kFreiburg1.project(3.7 * ray)).norm(), 1e-9);
}

TEST(Camera, KernelCopyAgreesToAHundredthOfAPixel) {
  const DistortedPinholeParams kernel = kFreiburg1.distorted_pinhole();
  for (double x = -0.6; x <= 0.6; x += 0.15) {
    for (double y = -0.45; y <= 0.45; y += 0.15) {
      const Eigen::Vector2d pixel = kFreiburg1.project({2 * x, 2 * y, 2});
      float u = 0, v = 0;
      kernel.project({static_cast<float>(2 * x), static_cast<float>(2 * y), 2.0f}, &u, &v);
      EXPECT_NEAR(u, pixel.x(), 0.01);
      EXPECT_NEAR(v, pixel.y(), 0.01);
    }
  }
}

TEST(Camera, PinholeKeepsTheIntrinsics) {
  const PinholeParams pinhole = kFreiburg1.pinhole();
  EXPECT_EQ(pinhole.width, 640);
  EXPECT_EQ(pinhole.height, 480);
  EXPECT_FLOAT_EQ(pinhole.fx, 517.306f);
  EXPECT_FLOAT_EQ(pinhole.cy, 255.314f);
}

TEST(Camera, KnowsWhetherItDistorts) {
  EXPECT_TRUE(kFreiburg1.is_distorted());
  EXPECT_FALSE(Camera().is_distorted());
}

std::string problem_after(const std::function<void(Camera&)>& change) {
  Camera camera = kFreiburg1;
  change(camera);
  return camera.problem();
}

TEST(Camera, AcceptsRealCameras) {
  EXPECT_EQ(kFreiburg1.problem(), "");
  EXPECT_EQ(Camera().problem(), "");
  EXPECT_EQ((Camera{160, 120, 128, 128, 79.5, 59.5, {}}).problem(), "");
}

TEST(Camera, NamesTheAbsurdField) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN(),
                   kInfinity = std::numeric_limits<double>::infinity();
  for (const double bad : {kNaN, kInfinity, -kInfinity, -480.0, 0.0, 1e9}) {
    EXPECT_THAT(problem_after([bad](Camera& c) { c.fx = bad; }), HasSubstr("fx is")) << bad;
    EXPECT_THAT(problem_after([bad](Camera& c) { c.fy = bad; }), HasSubstr("fy is")) << bad;
  }
  for (const double bad : {kNaN, kInfinity, -1.0, 1e6}) {
    EXPECT_THAT(problem_after([bad](Camera& c) { c.cx = bad; }), HasSubstr("cx is")) << bad;
    EXPECT_THAT(problem_after([bad](Camera& c) { c.cy = bad; }), HasSubstr("cy is")) << bad;
  }
  for (const int bad :
       {-640, 0, 1, 100'000, std::numeric_limits<int>::max(), std::numeric_limits<int>::min()}) {
    EXPECT_THAT(problem_after([bad](Camera& c) { c.width = bad; }), HasSubstr("width is")) << bad;
    EXPECT_THAT(problem_after([bad](Camera& c) { c.height = bad; }), HasSubstr("height is")) << bad;
  }
  for (size_t k = 0; k < 5; ++k) {
    for (const double bad : {kNaN, kInfinity, 1e6}) {
      EXPECT_THAT(problem_after([=](Camera& c) { c.distortion[k] = bad; }), HasSubstr("distortion"))
          << k << ' ' << bad;
    }
  }
}

TEST(Camera, DistortionThatFoldsTheImageIsAProblem) {
  const auto distorted = [](std::array<double, 5> distortion) {
    return problem_after([&](Camera& c) { c.distortion = distortion; });
  };
  const std::array<double, 5> folding[] = {
      {-2, 0, 0, 0, 0},     // the radial factor turns negative
      {-0.7, 0, 0, 0, 0},   // the distorted radius falls again towards the corners
      {0, 0, 0, 0, -5},     //
      {0, 0, 0.5, 0, 0},    // tangential
      {0, 0, 0, -0.5, 0}};  //
  for (const auto& distortion : folding) {
    EXPECT_THAT(distorted(distortion), HasSubstr("folds the image over at pixel")) << distortion[0];
    Camera camera = kFreiburg1;
    camera.distortion = distortion;
    EXPECT_EQ(camera.range_problem(), "");
  }
  EXPECT_EQ(distorted({-0.35, 0.15, 0.001, -0.001, -0.03}), "");
  EXPECT_EQ(distorted({0.3, 0.2, 0, 0, 0.1}), "");
}

}  // namespace
}  // namespace kt
