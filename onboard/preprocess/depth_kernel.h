// Kernels on depth images: conversion to metres, bilateral filter, pyramid.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "onboard/preprocess/depth_map.h"
#include "shared/core/vec.h"

namespace kt {

/// Raw sensor units -> metres in the undistorted camera (nearest source pixel: depth must not be blended
/// across edges).
struct ConvertDepth {
  const uint16_t* raw;    // as recorded
  const int32_t* source;  // source pixel of each undistorted pixel, -1 = outside
  float unit_m;           // metres per raw unit
  uint16_t invalid;       // raw value that means "none", besides 0
  float min_m, max_m;     // trusted range
  DepthView layout;
  float* depth_m;  // out, bordered

  KT_HOST_DEVICE void operator()(int u, int v) const {
    const int32_t from = source[int64_t{v} * layout.width + u];
    const uint16_t value = from >= 0 ? raw[from] : uint16_t{0};
    const float z = static_cast<float>(value) * unit_m;
    const bool valid = value != 0 && value != invalid && z >= min_m && z <= max_m;
    depth_m[layout.index(u, v)] = valid ? z : 0.0f;
  }
};

/// Bilateral filter (Tomasi and Manduchi 1998) with Tukey's biweight in range instead of a Gaussian: no
/// exponential, and a hard end that keeps depth edges and holes out. The range scale grows with the noise at
/// z.
struct BilateralFilter {
  static constexpr int kRadius = 3;
  DepthView input;
  float spatial[2 * kRadius + 1];  // one axis of the separable spatial weight
  float range_sigmas;              // end of the biweight in units of depth_sigma_m
  float* depth_m;                  // out, bordered

  KT_HOST_DEVICE void operator()(int u, int v) const {
    const float centre = input.at(u, v);
    const float range = range_sigmas * depth_sigma_m(centre);
    const float inverse_square_range = 1.0f / (range * range);
    float sum = 0.0f, weights = 0.0f;
    KT_UNROLL for (int dv = -kRadius; dv <= kRadius; ++dv) {
      KT_UNROLL for (int du = -kRadius; du <= kRadius; ++du) {
        const float z = input.at(u + du, v + dv);
        const float difference = z - centre;
        const float biweight =
            z > 0.0f ? max_of(0.0f, 1.0f - difference * difference * inverse_square_range) : 0.0f;
        const float weight = spatial[du + kRadius] * spatial[dv + kRadius] * biweight * biweight;
        sum += weight * z;
        weights += weight;
      }
    }
    depth_m[input.index(u, v)] = centre > 0.0f ? sum / weights : 0.0f;
  }
};

/// One pyramid level up: the mean of those of the 2 x 2 pixels that lie on one surface with the nearest one.
/// Without regard to its slope, only the nearer pixels of a slanted surface would count: every level would
/// lie before the one below. (Of a slope along the diagonal the farthest pixel counts up to 76 degrees.)
struct HalveDepth {
  DepthView fine;
  DepthView coarse;  // layout of the output
  float max_slope;   // of the fine level, as in ComputeNormal
  float* depth_m;    // out, bordered

  KT_HOST_DEVICE void operator()(int u, int v) const {
    const float z[4] = {fine.at(2 * u, 2 * v), fine.at(2 * u + 1, 2 * v), fine.at(2 * u, 2 * v + 1),
                        fine.at(2 * u + 1, 2 * v + 1)};
    float nearest = 1e9f;
    for (int k = 0; k < 4; ++k) nearest = z[k] > 0.0f ? min_of(nearest, z[k]) : nearest;
    const float limit = nearest + max_slope * nearest + 3.0f * depth_sigma_m(nearest);
    float sum = 0.0f, count = 0.0f;
    for (int k = 0; k < 4; ++k) {
      const float used = z[k] > 0.0f && z[k] <= limit ? 1.0f : 0.0f;
      sum += used * z[k];
      count += used;
    }
    depth_m[coarse.index(u, v)] = count > 0.0f ? sum / count : 0.0f;
  }
};

}  // namespace kt
