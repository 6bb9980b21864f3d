// Textures: detail near by, the same mean from afar, no shimmer between.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/synth/texture.h"

#include <gtest/gtest.h>

#include "shared/synth/palette.h"

namespace kt {
namespace {

struct Statistics {
  double mean = 0, deviation = 0;
};

// Green reflectance over a square of 1 m, sampled with the given footprint.
Statistics sample(const Material& material, double footprint) {
  double sum = 0, sum2 = 0;
  constexpr int kSamples = 400;
  for (int i = 0; i < kSamples; ++i) {
    for (int j = 0; j < kSamples; ++j) {
      const double g =
          reflectance(material, 0, {(i + 0.37) / kSamples, (j + 0.61) / kSamples, footprint, footprint}).y;
      EXPECT_TRUE(g >= 0 && g < 1.5);
      sum += g;
      sum2 += g * g;
    }
  }
  const double n = kSamples * kSamples, mean = sum / n;
  return {mean, std::sqrt(std::max(0.0, sum2 / n - mean * mean))};
}

TEST(Texture, KeepsItsMeanAndLosesContrastWithDistance) {
  const Material materials[] = {palette::oak(),
                                palette::plaster(),
                                palette::stone_tiles(),
                                palette::linen(),
                                palette::white_paint(),
                                palette::wallpaper({0.7f, 0.7f, 0.7f}, {0.3f, 0.3f, 0.3f}),
                                palette::poster({0.7f, 0.6f, 0.5f}, {0.1f, 0.1f, 0.2f}, 3),
                                palette::print({0.8f, 0.8f, 0.8f}, {0.1f, 0.1f, 0.1f}, 0.03)};
  for (const Material& material : materials) {
    SCOPED_TRACE(static_cast<int>(material.pattern));
    const Statistics near = sample(material, 0.001), middle = sample(material, 0.008),
                     far = sample(material, 0.1);
    EXPECT_GT(near.deviation, 0.008);
    EXPECT_LE(middle.deviation, near.deviation * 1.05);
    EXPECT_LT(far.deviation, near.deviation * 0.85);
    EXPECT_NEAR(middle.mean, near.mean, 0.05 * near.mean + 0.01);
    EXPECT_NEAR(far.mean, near.mean, 0.12 * near.mean + 0.01);
  }
}

TEST(Texture, WallpaperShowsCornersAtEveryWorkingDistance) {
  // Neighbouring pixels at 0.5 to 4 m must differ visibly somewhere within every patch of 64 x 64 pixels.
  const Material material = palette::wallpaper({0.66f, 0.60f, 0.47f}, {0.42f, 0.30f, 0.26f});
  for (const double distance : {0.5, 1.0, 2.0, 4.0}) {
    const double pixel = distance / 525;
    double strongest = 0;
    for (int i = 0; i < 64; ++i) {
      for (int j = 0; j < 64; ++j) {
        const auto green = [&](double u, double v) {
          return reflectance(material, 0, {0.31 + u * pixel, 0.17 + v * pixel, pixel, pixel}).y;
        };
        strongest = std::max(strongest, std::abs(static_cast<double>(green(i + 1, j) - green(i - 1, j))));
      }
    }
    EXPECT_GT(strongest, 0.03) << distance;
  }
}

TEST(Texture, DiffersBetweenSeedsAndFacesButNotBetweenCalls) {
  Material material = palette::plaster();
  const Footprint at{0.123, 0.456, 0.002, 0.002};
  const Vec3f here = reflectance(material, 0, at), again = reflectance(material, 0, at),
              other_face = reflectance(material, 1, at);
  material.seed += 1;
  EXPECT_EQ(here.x, again.x);
  EXPECT_NE(here.x, other_face.x);
  EXPECT_NE(here.x, reflectance(material, 0, at).x);
}

}  // namespace
}  // namespace kt
