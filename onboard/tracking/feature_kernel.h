// Kernels that find corners in an intensity image, the surface point behind each, and describe them.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "onboard/preprocess/depth_map.h"
#include "onboard/preprocess/intensity_kernel.h"
#include "shared/core/row_motion.h"

namespace kt {

/// Binomial 3 x 3 filter; negative where one of the nine pixels shows nothing.
struct SmoothIntensity {
  IntensityView image;
  float* levels;  // out

  KT_HOST_DEVICE void operator()(int u, int v) const {
    const int64_t i = int64_t{v} * image.width + u;
    levels[i] = -1.0f;
    if (u < 1 || v < 1 || u >= image.width - 1 || v >= image.height - 1) return;
    constexpr float kWeights[3] = {0.25f, 0.5f, 0.25f};
    float sum = 0.0f, least = 0.0f;
    KT_UNROLL for (int dv = -1; dv <= 1; ++dv) {
      KT_UNROLL for (int du = -1; du <= 1; ++du) {
        const float level = image.levels[i + int64_t{dv} * image.width + du];
        sum += kWeights[du + 1] * kWeights[dv + 1] * level;
        least = min_of(least, level);
      }
    }
    levels[i] = least < 0.0f ? -1.0f : sum;
  }
};

/// How much of a corner a pixel is: the smaller eigenvalue of the gradients' second moments over 5 x 5 pixels
/// (Shi and Tomasi 1994), per pixel; 0 where the image shows nothing.
struct ScoreCorner {
  static constexpr int kRadius = 2;
  IntensityView image;  // smoothed
  float* scores;        // out

  KT_HOST_DEVICE void operator()(int u, int v) const {
    constexpr int kMargin = kRadius + 1;
    float score = 0.0f;
    if (u >= kMargin && v >= kMargin && u < image.width - kMargin && v < image.height - kMargin) {
      float xx = 0.0f, xy = 0.0f, yy = 0.0f, least = 0.0f;
      KT_UNROLL for (int dv = -kRadius; dv <= kRadius; ++dv) {
        const float* row = image.levels + int64_t{v + dv} * image.width + u;
        KT_UNROLL for (int du = -kRadius; du <= kRadius; ++du) {
          const float right = row[du + 1], left = row[du - 1], below = row[du + image.width],
                      above = row[du - image.width];
          const float gx = 0.5f * (right - left), gy = 0.5f * (below - above);
          xx += gx * gx;
          xy += gx * gy;
          yy += gy * gy;
          least = min_of(least, min_of(min_of(right, left), min_of(below, above)));
        }
      }
      constexpr float kPixels = (2 * kRadius + 1) * (2 * kRadius + 1);
      const float half = 0.5f * (xx - yy);
      const float smaller = 0.5f * (xx + yy) - sqrtf(half * half + xy * xy);
      score = least < 0.0f ? 0.0f : smaller / kPixels;
    }
    scores[int64_t{v} * image.width + u] = score;
  }
};

/// 256 comparisons of intensities around a corner, turned with it (ORB, Rublee et al. 2011).
struct BinaryDescriptor {
  static constexpr int kWords = 8;
  uint32_t bits[kWords] = {};
};

/// Two points that a descriptor compares, in pixels from the corner.
struct DescriptorPair {
  int8_t u1, v1, u2, v2;
};

/// A corner as the kernel finds it.
struct DetectedFeature {
  float u = 0, v = 0;  // pixel, of the image's level
  Vec3f p_camera;      // its point in the depth camera (m)
  BinaryDescriptor descriptor;
  int32_t is_found = 0;  // 0: the rest means nothing
};

/// Finds the point of the surface behind a pixel of the colour camera.
struct SurfaceBehind {
  PinholeParams camera;  // colour, of any level
  DepthView depth;       // of any level; null where there is none
  PinholeParams depth_camera;
  /// From the depth camera at the middle row of its image to the colour camera at that of its own, and back.
  Rigid3f T_colour_depth, T_depth_colour;
  RowMotion colour_rows{}, depth_rows{};

  /// The point of the surface that a pixel of the colour camera shows, in the depth camera at the middle row
  /// of its image: the ray of the pixel is followed through the depth image until both agree. False at holes,
  /// and beside edges of depth, where nobody knows.
  KT_HOST_DEVICE bool find(float u, float v, Vec3f* p_camera) const {
    constexpr int kRounds = 5;
    constexpr float kAgreement_px = 1.0f;
    const Vec3f ray = camera.unproject(u, v, 1.0f);
    float z_colour = 2.0f;
    for (int round = 0; round < kRounds; ++round) {
      const Vec3f settled = T_depth_colour * colour_rows.to_middle(ray * z_colour, v);
      if (settled.z <= 0.05f) return false;
      const Vec3f guess = depth_rows.to_row(settled, depth_camera.project_v(settled));
      if (guess.z <= 0.05f) return false;
      const float du = depth_camera.project_u(guess) + 0.5f, dv = depth_camera.project_v(guess) + 0.5f;
      if (!(du >= 1.0f && dv >= 1.0f && du < static_cast<float>(depth.width - 1) &&
            dv < static_cast<float>(depth.height - 1)))
        return false;
      const int pu = static_cast<int>(du), pv = static_cast<int>(dv);
      const float z = depth.at(pu, pv);
      if (z <= 0.0f) return false;
      *p_camera = depth_rows.to_middle(depth_camera.unproject(du - 0.5f, dv - 0.5f, z), dv - 0.5f);
      z_colour = colour_rows.to_row(T_colour_depth * *p_camera, v).z;
      if (round + 1 == kRounds && is_beside_edge(pu, pv, z)) return false;
    }
    const Vec3f p_colour = colour_rows.to_row(T_colour_depth * *p_camera, v);
    return p_colour.z > 0.05f && fabsf(camera.project_u(p_colour) - u) < kAgreement_px &&
           fabsf(camera.project_v(p_colour) - v) < kAgreement_px;
  }

 private:
  KT_HOST_DEVICE bool is_beside_edge(int u, int v, float z) const {
    const float limit = 0.04f * z;
    for (int dv = -1; dv <= 1; ++dv) {
      for (int du = -1; du <= 1; ++du) {
        const float other = depth.at(u + du, v + dv);
        if (other <= 0.0f || fabsf(other - z) > limit) return true;
      }
    }
    return false;
  }
};

/// The best corner of one cell of the image that has a depth, if there is one: so features spread over the
/// image, and need no sorting.
struct DetectFeature {
  static constexpr int kSmallestCellSide = 8;
  static constexpr int kReach = 13;  // pixels from the corner that the descriptor may look at

  int32_t cell_side;    // pixels
  IntensityView image;  // smoothed
  const float* scores;  // of the same size
  float min_score;      // square grey levels per square pixel
  SurfaceBehind surface;
  const DescriptorPair* pairs;  // one per bit
  DetectedFeature* features;    // out, by cell

  KT_HOST_DEVICE int cells_across(int pixels) const { return pixels / cell_side; }

  KT_HOST_DEVICE void operator()(int64_t cell) const {
    DetectedFeature feature;
    int u = 0, v = 0;
    if (find_corner(cell, &u, &v)) {
      feature.u = static_cast<float>(u) + peak_offset(score(u - 1, v), score(u, v), score(u + 1, v));
      feature.v = static_cast<float>(v) + peak_offset(score(u, v - 1), score(u, v), score(u, v + 1));
      if (has_point(feature.u, feature.v, &feature.p_camera) && describe(u, v, &feature.descriptor))
        feature.is_found = 1;
    }
    features[cell] = feature;
  }

 private:
  KT_HOST_DEVICE bool has_point(float u, float v, Vec3f* p_camera) const {
    return !surface.depth.depth_m || surface.find(u, v, p_camera);
  }
  KT_HOST_DEVICE float score(int u, int v) const { return scores[int64_t{v} * image.width + u]; }

  KT_HOST_DEVICE bool find_corner(int64_t cell, int* best_u, int* best_v) const {
    const int across = cells_across(image.width);
    const int first_u = static_cast<int>(cell % across) * cell_side,
              first_v = static_cast<int>(cell / across) * cell_side;
    float best = min_score;
    bool is_found = false;
    for (int v = first_v; v < first_v + cell_side; ++v) {
      for (int u = first_u; u < first_u + cell_side; ++u) {
        if (u <= kReach || v <= kReach || u >= image.width - kReach || v >= image.height - kReach) continue;
        Vec3f p_camera;
        if (score(u, v) <= best || !is_peak(u, v) ||
            !has_point(static_cast<float>(u), static_cast<float>(v), &p_camera))
          continue;
        best = score(u, v);
        *best_u = u;
        *best_v = v;
        is_found = true;
      }
    }
    return is_found;
  }

  KT_HOST_DEVICE bool is_peak(int u, int v) const {
    const float here = score(u, v);
    for (int dv = -1; dv <= 1; ++dv) {
      for (int du = -1; du <= 1; ++du) {
        if (score(u + du, v + dv) > here) return false;
      }
    }
    return true;
  }

  // Where the parabola through three equidistant values has its top, from the middle one.
  KT_HOST_DEVICE static float peak_offset(float before, float here, float after) {
    const float curvature = before - 2.0f * here + after;
    return curvature < 0.0f ? max_of(-0.5f, min_of(0.5f, 0.5f * (before - after) / curvature)) : 0.0f;
  }

  // The direction of a corner is that of its intensity centroid (Rosin 1999) over a disc.
  KT_HOST_DEVICE bool describe(int u, int v, BinaryDescriptor* descriptor) const {
    constexpr int kRadius = 7;
    float m10 = 0.0f, m01 = 0.0f;
    for (int dv = -kReach; dv < kReach; ++dv) {
      const float* row = image.levels + int64_t{v + dv} * image.width + u;
      for (int du = -kReach; du < kReach; ++du) {
        if (row[du] < 0.0f) return false;
        if (du * du + dv * dv > kRadius * kRadius) continue;
        m10 += static_cast<float>(du) * row[du];
        m01 += static_cast<float>(dv) * row[du];
      }
    }
    const float length = sqrtf(m10 * m10 + m01 * m01);
    const float c = length > 0.0f ? m10 / length : 1.0f, s = length > 0.0f ? m01 / length : 0.0f;
    for (int bit = 0; bit < 32 * BinaryDescriptor::kWords; ++bit) {
      const DescriptorPair pair = pairs[bit];
      const bool is_brighter = turned(u, v, pair.u1, pair.v1, c, s) > turned(u, v, pair.u2, pair.v2, c, s);
      descriptor->bits[bit / 32] |= (is_brighter ? 1u : 0u) << (bit % 32);
    }
    return true;
  }
  KT_HOST_DEVICE float turned(int u, int v, int du, int dv, float c, float s) const {
    const float x = c * static_cast<float>(du) - s * static_cast<float>(dv),
                y = s * static_cast<float>(du) + c * static_cast<float>(dv);
    const int tu = u + static_cast<int>(floorf(x + 0.5f)), tv = v + static_cast<int>(floorf(y + 0.5f));
    return image.levels[int64_t{tv} * image.width + tu];
  }
};

}  // namespace kt
