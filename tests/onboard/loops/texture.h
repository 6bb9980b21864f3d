// Made-up images for tests of keypoints.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>

#include "shared/core/image.h"
#include "shared/core/rng.h"

namespace kt::test {

/// Adds a round blob of `amplitude` grey levels.
inline void add_blob(Image<float>& image, double u, double v, double sigma, double amplitude) {
  const int reach = static_cast<int>(4 * sigma) + 1;
  for (int y = std::max(0, static_cast<int>(v) - reach);
       y < std::min(image.height(), static_cast<int>(v) + reach); ++y) {
    for (int x = std::max(0, static_cast<int>(u) - reach);
         x < std::min(image.width(), static_cast<int>(u) + reach); ++x) {
      const double square = (x - u) * (x - u) + (y - v) * (y - v);
      image(x, y) += static_cast<float>(amplitude * std::exp(-square / (2 * sigma * sigma)));
    }
  }
}

/// Many blobs of sizes from 1.5 to 8 pixels.
inline Image<float> blotches(int width, int height, uint64_t seed) {
  Image<float> image(width, height, 120.0f);
  const auto count = static_cast<uint64_t>(width) * static_cast<uint64_t>(height) / 60;
  for (uint64_t k = 0; k < count; ++k) {
    const auto share = [&](uint64_t which) { return random_uniform(seed, which, k); };
    add_blob(image, share(0) * width, share(1) * height, 1.5 * std::pow(5.3, share(2)), 120 * share(3) - 60);
  }
  for (float& level : image.pixels()) level = std::clamp(level, 0.0f, 255.0f);
  return image;
}

}  // namespace kt::test
