// Kernels that make the intensity pyramid of the undistorted colour camera.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "shared/core/host_device.h"
#include "shared/core/image.h"
#include "shared/core/pinhole.h"

namespace kt {

/// An intensity image (grey levels, 0 to 255; negative where the lens shows nothing) that kernels look up.
struct IntensityView {
  const float* levels = nullptr;
  int32_t width = 0, height = 0;

  /// Bilinear value, and its exact derivative by u and v, at a pixel; false where one of the four pixels
  /// around is outside or shows nothing.
  KT_HOST_DEVICE bool sample(float u, float v, float* level, float* by_u, float* by_v) const {
    if (!(u >= 0.0f && v >= 0.0f && u < static_cast<float>(width - 1) && v < static_cast<float>(height - 1)))
      return false;
    const int u0 = static_cast<int>(u), v0 = static_cast<int>(v);
    const float fu = u - static_cast<float>(u0), fv = v - static_cast<float>(v0);
    const float* row0 = levels + int64_t{v0} * width + u0;
    const float* row1 = row0 + width;
    if (row0[0] < 0.0f || row0[1] < 0.0f || row1[0] < 0.0f || row1[1] < 0.0f) return false;
    const float upper = row0[0] + fu * (row0[1] - row0[0]), lower = row1[0] + fu * (row1[1] - row1[0]);
    *level = upper + fv * (lower - upper);
    *by_u = (row0[1] - row0[0]) + fv * ((row1[1] - row1[0]) - (row0[1] - row0[0]));
    *by_v = lower - upper;
    return true;
  }
};

/// Luma (ITU-R BT.601) of the image as recorded at half its resolution: the mean of 2 x 2 pixels.
struct HalveToIntensity {
  const Rgb8* colour;
  int32_t colour_width;
  int32_t width;
  float* levels;  // out

  KT_HOST_DEVICE void operator()(int u, int v) const {
    const Rgb8* row0 = colour + int64_t{2 * v} * colour_width + 2 * u;
    const Rgb8* row1 = row0 + colour_width;
    const int r = row0[0].r + row0[1].r + row1[0].r + row1[1].r,
              g = row0[0].g + row0[1].g + row1[0].g + row1[1].g,
              b = row0[0].b + row0[1].b + row1[0].b + row1[1].b;
    levels[int64_t{v} * width + u] =
        0.25f *
        (0.299f * static_cast<float>(r) + 0.587f * static_cast<float>(g) + 0.114f * static_cast<float>(b));
  }
};

/// Where each pixel of the undistorted camera lies in the image as recorded, both at half resolution.
struct LensPosition {
  float u = -1, v = -1;
};

struct UndistortIntensity {
  IntensityView recorded;
  const LensPosition* positions;
  float* levels;  // out

  KT_HOST_DEVICE void operator()(int u, int v) const {
    const int64_t i = int64_t{v} * recorded.width + u;
    float level, by_u, by_v;
    levels[i] = recorded.sample(positions[i].u, positions[i].v, &level, &by_u, &by_v) ? level : -1.0f;
  }
};

/// One pyramid level up: the mean of 2 x 2 pixels, nothing where one of them shows nothing.
struct HalveIntensity {
  IntensityView fine;
  int32_t width;
  float* levels;  // out

  KT_HOST_DEVICE void operator()(int u, int v) const {
    const float* row0 = fine.levels + int64_t{2 * v} * fine.width + 2 * u;
    const float* row1 = row0 + fine.width;
    const bool shown = (row0[0] >= 0.0f) & (row0[1] >= 0.0f) & (row1[0] >= 0.0f) & (row1[1] >= 0.0f);
    levels[int64_t{v} * width + u] = shown ? 0.25f * (row0[0] + row0[1] + row1[0] + row1[1]) : -1.0f;
  }
};

}  // namespace kt
