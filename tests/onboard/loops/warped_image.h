// An image seen again under a known homography, and how many keypoints are found again in it.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "Eigen/Core"
#include "Eigen/Geometry"
#include "Eigen/LU"

#include "shared/core/image.h"
#include "shared/core/rng.h"

namespace kt::test {

/// Turns by `degrees` about the centre, enlarges by `scale` and tilts: what lies at the right edge shrinks by
/// `tilt` against the centre. Maps pixels of an image to those of another of the given size.
inline Eigen::Matrix3d homography(const Image<float>& from, int width, int height, double degrees,
                                  double scale, double tilt = 0) {
  const double angle = degrees * std::numbers::pi / 180, c = scale * std::cos(angle),
               s = scale * std::sin(angle);
  Eigen::Matrix3d centred, turned, placed;
  centred << 1, 0, -0.5 * (from.width() - 1), 0, 1, -0.5 * (from.height() - 1), 0, 0, 1;
  turned << c, -s, 0, s, c, 0, 2 * tilt / width, 0, 1;
  placed << 1, 0, 0.5 * (width - 1), 0, 1, 0.5 * (height - 1), 0, 0, 1;
  return placed * turned * centred;
}

inline Eigen::Vector2d mapped(const Eigen::Matrix3d& H, double u, double v) {
  return (H * Eigen::Vector3d(u, v, 1)).hnormalized();
}

/// `from` under H, bilinear, with noise of `sigma` grey levels; -1 where `from` shows nothing.
inline Image<float> warped(const Image<float>& from, const Eigen::Matrix3d& H, int width, int height,
                           double sigma = 0) {
  Image<float> image(width, height, -1.0f);
  const Eigen::Matrix3d back = H.inverse();
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      const Eigen::Vector2d at = mapped(back, u, v);
      if (!(at.x() >= 0 && at.y() >= 0 && at.x() < from.width() - 1 && at.y() < from.height() - 1)) continue;
      const int u0 = static_cast<int>(at.x()), v0 = static_cast<int>(at.y());
      const double fu = at.x() - u0, fv = at.y() - v0;
      const double level =
          (1 - fv) * ((1 - fu) * from(u0, v0) + fu * from(u0 + 1, v0)) +
          fv * ((1 - fu) * from(u0, v0 + 1) + fu * from(u0 + 1, v0 + 1)) +
          sigma * random_normal(7, 0, static_cast<uint64_t>(v) * static_cast<uint64_t>(width) + u);
      image(u, v) = static_cast<float>(std::clamp(std::round(level), 0.0, 255.0));
    }
  }
  return image;
}

/// A keypoint of any extractor.
struct Spot {
  double u, v, scale;
  std::vector<float> descriptor;
};

struct Refound {
  double seen = 0;     ///< keypoints of the first image whose surroundings the second shows
  double refound = 0;  ///< of them, those with one of a similar size at their place
  double matched = 0;  ///< of them, those whose descriptor is nearest to that of one at their place
  Refound& operator+=(const Refound& other) {
    seen += other.seen;
    refound += other.refound;
    matched += other.matched;
    return *this;
  }
  double repeatability() const { return refound / seen; }
  double matching() const { return matched / seen; }
};

/// `scale` is how much H enlarges.
inline Refound compare(const std::vector<Spot>& first, const std::vector<Spot>& second,
                       const Eigen::Matrix3d& H, double scale, int width, int height) {
  constexpr double kSupport = 17, kNear_px = 2, kLargestRatio = 1.4;
  Refound result;
  for (const Spot& a : first) {
    const Eigen::Vector2d at = mapped(H, a.u, a.v);
    const double support = kSupport * a.scale * scale;
    if (at.x() < support || at.y() < support || at.x() > width - 1 - support || at.y() > height - 1 - support)
      continue;
    ++result.seen;
    bool is_refound = false, is_matched = false;
    float nearest = std::numeric_limits<float>::infinity();
    for (const Spot& b : second) {
      const double ratio = b.scale / (a.scale * scale);
      const bool is_same =
          (Eigen::Vector2d(b.u, b.v) - at).norm() < kNear_px * std::max(1.0, b.scale / 2.5) &&
          ratio < kLargestRatio && ratio > 1 / kLargestRatio;
      is_refound |= is_same;
      float square = 0;
      for (size_t k = 0; k < a.descriptor.size(); ++k) {
        const float difference = a.descriptor[k] - b.descriptor[k];
        square += difference * difference;
      }
      if (square < nearest) {
        nearest = square;
        is_matched = is_same;
      }
    }
    result.refound += is_refound;
    result.matched += is_matched;
  }
  return result;
}

}  // namespace kt::test
