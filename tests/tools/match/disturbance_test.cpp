// Disturbances of small images whose result is known.
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/match/disturbance.h"

#include <cmath>
#include <gtest/gtest.h>

namespace kt {
namespace {

Image<Rgb8> spot() {
  Image<Rgb8> image(41, 31);
  image(20, 15) = {200, 100, 50};
  return image;
}

double sum_of_red(const Image<Rgb8>& image) {
  double sum = 0;
  for (const Rgb8& pixel : image.pixels()) sum += pixel.r;
  return sum;
}

TEST(Disturbance, OfNoSizeChangesNothing) {
  const Image<Rgb8> image = spot();
  EXPECT_EQ(disturbed(image, Disturbance::kBlur, 0, 1), image);
  EXPECT_EQ(disturbed(image, Disturbance::kMotion, 0, 1), image);
  EXPECT_EQ(disturbed(image, Disturbance::kGain, 1, 1), image);
  EXPECT_EQ(disturbed(image, Disturbance::kNoise, 0, 1), image);
}

TEST(Disturbance, BlurIsGaussian) {
  const Image<Rgb8> result = disturbed(spot(), Disturbance::kBlur, 1, 1);
  for (int d = 0; d <= 2; ++d) {
    EXPECT_NEAR(result(20 + d, 15).r, 200 / (2 * M_PI) * std::exp(-0.5 * d * d), 1) << d;
    EXPECT_EQ(result(20 + d, 15), result(20, 15 + d));
  }
}

TEST(Disturbance, AStreakIsHorizontalAndKeepsTheLight) {
  const Image<Rgb8> result = disturbed(spot(), Disturbance::kMotion, 4, 1);
  for (int u = 0; u < result.width(); ++u) EXPECT_EQ(result(u, 15).r, std::abs(u - 20) <= 2 ? 40 : 0) << u;
  EXPECT_EQ(sum_of_red(result), 200);
}

TEST(Disturbance, GainClips) {
  EXPECT_EQ(disturbed(spot(), Disturbance::kGain, 2, 1)(20, 15), (Rgb8{255, 200, 100}));
  EXPECT_EQ(disturbed(spot(), Disturbance::kGain, 0.5, 1)(20, 15), (Rgb8{100, 50, 25}));
}

TEST(Disturbance, NoiseHasItsSizeAndIsRepeatable) {
  const Image<Rgb8> grey(100, 100, Rgb8{128, 128, 128});
  const Image<Rgb8> result = disturbed(grey, Disturbance::kNoise, 10, 1);
  double squares = 0;
  for (const Rgb8& pixel : result.pixels()) squares += (pixel.g - 128.0) * (pixel.g - 128.0);
  EXPECT_NEAR(std::sqrt(squares / 1e4), 10, 0.3);
  EXPECT_EQ(result, disturbed(grey, Disturbance::kNoise, 10, 1));
  EXPECT_NE(result, disturbed(grey, Disturbance::kNoise, 10, 2));
}

}  // namespace
}  // namespace kt
