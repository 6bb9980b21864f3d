// The depth camera's flaws: their size, where they occur, and that they depend on nothing but frame and
// pixel.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/synth/sensor.h"

#include <gtest/gtest.h>

#include "shared/synth/scene.h"

namespace kt {
namespace {

using Eigen::Vector3d;

constexpr double kUnit = 1.0 / 5000;
const Camera kCamera{};

// A sheet of half size `half` through (x, 0, z), turned by `angle` about the y axis.
void add_sheet(Scene* scene, double x, double z, double half, double angle, float infrared = 1) {
  Pose T = Pose::Identity();
  T.linear() = exp_so3({0, angle, 0});
  T.translation() = Vector3d(x, 0, z);
  Material material;
  material.infrared = infrared;
  scene->add({ShapeKind::kQuad, {half, half, 0}}, T, material);
}

struct Seen {
  View view;
  Image<uint16_t> depth;
};

Seen look_at(const Scene& scene, int64_t frame = 7, int threads = 2) {
  View view = Renderer(scene, kCamera).render(Pose::Identity(), false);
  Image<uint16_t> depth = flawed_depth(view, scene, kUnit, {}, 5, frame, threads);
  return {std::move(view), std::move(depth)};
}

// Share of holes in columns [from, to).
double hole_share(const Image<uint16_t>& depth, int from, int to) {
  int holes = 0;
  for (int v = 0; v < depth.height(); ++v) {
    for (int u = from; u < to; ++u) holes += depth(u, v) == 0;
  }
  return static_cast<double>(holes) / (depth.height() * (to - from));
}

TEST(FlawedDepth, ErrorGrowsWithTheSquareOfDepth) {
  for (const double z : {1.0, 2.0, 3.0}) {
    Scene scene;
    add_sheet(&scene, 0, z, 10, 0.12);  // turned a little, to cross many disparity steps
    const Seen seen = look_at(scene);
    double sum = 0, sum2 = 0, count = 0;
    for (int64_t i = 0; i < seen.depth.pixel_count(); ++i) {
      const double exact = seen.view.z_m.data()[i];
      if (seen.depth.data()[i] == 0 || std::abs(exact - z) > 0.05 * z) continue;
      const double error = seen.depth.data()[i] * kUnit - exact;
      sum += error, sum2 += error * error, ++count;
    }
    ASSERT_GT(count, 100000);
    const double sigma = std::sqrt(sum2 / count);
    EXPECT_NEAR(sigma, 0.001425 * z * z, 0.1 * 0.001425 * z * z) << z;
    EXPECT_LT(std::abs(sum / count), 0.1 * sigma) << z;
  }
}

TEST(FlawedDepth, NeighboursShareAPartOfTheirError) {
  Scene scene;
  add_sheet(&scene, 0, 2, 10, 0.12);
  const Seen seen = look_at(scene);
  double together = 0, apart = 0, power = 0;
  const auto error = [&](int u, int v) { return seen.depth(u, v) * kUnit - seen.view.z_m(u, v); };
  for (int v = 100; v < 380; v += 2) {
    for (int u = 100; u < 540; u += 2) {
      power += error(u, v) * error(u, v);
      together += error(u, v) * error(u + 1, v + 1);  // the same block of 2 x 2
      apart += error(u, v) * error(u - 1, v - 1);     // another block
    }
  }
  EXPECT_GT(together / power, 0.25);
  EXPECT_LT(std::abs(apart / power), 0.25 * together / power);
}

TEST(FlawedDepth, EndsNearFarAndAtGrazingAngles) {
  const auto holes = [](double z, double angle, float infrared = 1) {
    Scene scene;
    add_sheet(&scene, 0, z, 30, angle, infrared);
    return hole_share(look_at(scene).depth, 300, 340);
  };
  EXPECT_EQ(holes(0.35, 0), 1);
  EXPECT_LT(holes(0.45, 0), 0.001);
  EXPECT_LT(holes(4.4, 0), 0.001);
  EXPECT_GT(holes(4.75, 0), 0.3);  // the smooth end
  EXPECT_LT(holes(4.75, 0), 0.7);
  EXPECT_EQ(holes(5.05, 0), 1);
  EXPECT_LT(holes(2, 1.2), 0.001);  // 69 degrees
  EXPECT_GT(holes(2, 1.5), 0.999);  // 86 degrees
  EXPECT_NEAR(holes(2, 0, 0.5f), 0.5, 0.12);
  EXPECT_GT(holes(2, 0, 0), 0.99);
}

TEST(FlawedDepth, ThingsThrowAShadowToTheirLeftOnly) {
  // A sheet at 1 m, |x| < 0.15, before a wall at 2 m: the shadow is 39.4 px * (1/1 - 1/2) = 19.7 px wide.
  Scene scene;
  add_sheet(&scene, 0, 1, 0.15, 0);
  add_sheet(&scene, 0, 2, 10, 0);
  const Image<uint16_t> depth = look_at(scene).depth;
  const auto row_holes = [&](int from, int to) {
    int holes = 0;
    for (int u = from; u < to; ++u) holes += depth(u, 240) == 0;
    return holes;
  };
  // The sheet covers u = 319.5 +- 78.75.
  EXPECT_NEAR(row_holes(200, 240), 19.7, 4);
  EXPECT_EQ(row_holes(180, 215), 0);
  EXPECT_LE(row_holes(390, 410), 4);  // edge jitter
  EXPECT_EQ(row_holes(405, 460), 0);
}

TEST(FlawedDepth, EdgesWanderByAboutAPixel) {
  Scene scene;
  add_sheet(&scene, 0, 1, 0.15, 0);
  add_sheet(&scene, 0, 2, 10, 0);
  const Image<uint16_t> depth = look_at(scene).depth;
  // Right edge at u = 398.25 in rows of the sheet: last near pixel per row.
  double sum = 0, sum2 = 0;
  int rows = 0;
  for (int v = 170; v < 310; ++v, ++rows) {
    int last = 380;
    for (int u = 380; u < 420; ++u) last = depth(u, v) > 0 && depth(u, v) < 7500 ? u : last;
    sum += last - 398, sum2 += (last - 398) * (last - 398);
  }
  EXPECT_LT(std::abs(sum / rows), 1.0);
  const double spread = std::sqrt(sum2 / rows);
  EXPECT_GT(spread, 0.4);
  EXPECT_LT(spread, 2.0);
}

TEST(FlawedDepth, DependsOnFrameAndPixelAloneNotOnThreads) {
  Scene scene;
  add_sheet(&scene, 0, 1, 0.15, 0.3);
  add_sheet(&scene, 0, 2, 10, 0.1);
  EXPECT_EQ(look_at(scene, 3, 1).depth, look_at(scene, 3, 3).depth);
  EXPECT_NE(look_at(scene, 3).depth, look_at(scene, 4).depth);
}

TEST(ExactDepth, RoundsToTheNearestUnitAndDropsWhatDoesNotFit) {
  View view{
      Image<double>(4, 1, {1.00009, 1.00011, 14.0, std::numeric_limits<double>::infinity()}), {}, {}, {}};
  EXPECT_EQ(exact_depth(view, kUnit), Image<uint16_t>(4, 1, {5000, 5001, 0, 0}));
}

TEST(Expose, GrainHasSigmaOfTwoLevelsAndNoBias) {
  const Image<Vec3f> grey(400, 300, Vec3f{0.25f, 0.25f, 0.25f});
  const Image<Rgb8> clear = expose(grey, {1, 1, 1}, false, 1, 1, 2),
                    noisy = expose(grey, {1, 1, 1}, true, 1, 1, 2);
  double sum = 0, sum2 = 0, red_green = 0;
  for (int64_t i = 0; i < grey.pixel_count(); ++i) {
    EXPECT_EQ(clear.data()[i].g, 128);  // sqrt(0.25) * 255, rounded
    const double error = noisy.data()[i].g - 128.0;
    sum += error, sum2 += error * error, red_green += error * (noisy.data()[i].r - 128.0);
  }
  const double n = static_cast<double>(grey.pixel_count());
  EXPECT_NEAR(std::sqrt(sum2 / n), 2.236, 0.03);
  EXPECT_NEAR(sum / n, 0, 0.03);
  EXPECT_LT(std::abs(red_green / sum2), 0.02);
  EXPECT_EQ(expose(grey, {1, 1, 1}, true, 1, 1, 1), noisy);
}

TEST(Expose, GainScalesLightAndSaturates) {
  const Image<Vec3f> light(2, 1, {{0.25f, 0.25f, 0.25f}, {0.9f, 0.9f, 0.9f}});
  const Image<Rgb8> colour = expose(light, {1, 1.44f, 4}, false, 1, 1, 1);
  EXPECT_EQ(colour(0, 0), (Rgb8{128, 153, 255}));
  EXPECT_EQ(colour(1, 0).b, 255);
}

}  // namespace
}  // namespace kt
