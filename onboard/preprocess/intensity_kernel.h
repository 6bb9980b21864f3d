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

  /// Bilinear values at kLanes pixels and their exact derivatives by u and v; `shown` is 0 where one of the
  /// four pixels around is outside or shows nothing.
  template <int kLanes>
  struct Samples {
    float level[kLanes], by_u[kLanes], by_v[kLanes];
    int32_t shown[kLanes];
  };
  template <int kLanes>
  KT_HOST_DEVICE void sample(const float* u, const float* v, Samples<kLanes>* samples) const {
    const float last_u = static_cast<float>(width - 1), last_v = static_cast<float>(height - 1);
    int32_t inside[kLanes], at[kLanes];
    float fu[kLanes], fv[kLanes], upper_left[kLanes], upper_right[kLanes], lower_left[kLanes],
        lower_right[kLanes];
    for (int l = 0; l < kLanes; ++l) {
      inside[l] = (u[l] >= 0.0f) & (v[l] >= 0.0f) & (u[l] < last_u) & (v[l] < last_v);
      const float at_u = inside[l] ? u[l] : 0.0f, at_v = inside[l] ? v[l] : 0.0f;
      const int32_t u0 = static_cast<int32_t>(at_u), v0 = static_cast<int32_t>(at_v);
      fu[l] = at_u - static_cast<float>(u0);
      fv[l] = at_v - static_cast<float>(v0);
      at[l] = v0 * width + u0;
    }
    for (int l = 0; l < kLanes; ++l) upper_left[l] = levels[at[l]];
    for (int l = 0; l < kLanes; ++l) upper_right[l] = levels[at[l] + 1];
    for (int l = 0; l < kLanes; ++l) lower_left[l] = levels[at[l] + width];
    for (int l = 0; l < kLanes; ++l) lower_right[l] = levels[at[l] + width + 1];
    for (int l = 0; l < kLanes; ++l) {
      const float across_upper = upper_right[l] - upper_left[l],
                  across_lower = lower_right[l] - lower_left[l];
      const float upper = upper_left[l] + fu[l] * across_upper, lower = lower_left[l] + fu[l] * across_lower;
      samples->level[l] = upper + fv[l] * (lower - upper);
      samples->by_u[l] = across_upper + fv[l] * (across_lower - across_upper);
      samples->by_v[l] = lower - upper;
      samples->shown[l] = inside[l] & (upper_left[l] >= 0.0f) & (upper_right[l] >= 0.0f) &
                          (lower_left[l] >= 0.0f) & (lower_right[l] >= 0.0f);
    }
  }
  /// At one pixel; false where nothing is shown.
  KT_HOST_DEVICE bool sample(float u, float v, float* level, float* by_u, float* by_v) const {
    Samples<1> samples;
    sample(&u, &v, &samples);
    *level = samples.level[0];
    *by_u = samples.by_u[0];
    *by_v = samples.by_v[0];
    return samples.shown[0] != 0;
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
