// The undistorted pinhole camera as kernels see it.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "shared/core/vec.h"

namespace kt {

/// Pinhole intrinsics in pixels; pixel (0, 0) is the centre of the top left pixel.
struct PinholeParams {
  float fx = 0, fy = 0, cx = 0, cy = 0;
  int32_t width = 0, height = 0;

  /// Point in the camera frame (m) on the ray of pixel (u, v) at depth `z` (m).
  KT_HOST_DEVICE Vec3f unproject(float u, float v, float z) const {
    return {(u - cx) / fx * z, (v - cy) / fy * z, z};
  }
  /// Pixel coordinates of a point in the camera frame; needs p.z > 0.
  KT_HOST_DEVICE float project_u(Vec3f p) const { return p.x / p.z * fx + cx; }
  KT_HOST_DEVICE float project_v(Vec3f p) const { return p.y / p.z * fy + cy; }

  /// The same camera at half the resolution (one pyramid level up).
  PinholeParams half() const {
    return {fx / 2, fy / 2, (cx + 0.5f) / 2 - 0.5f, (cy + 0.5f) / 2 - 0.5f, width / 2, height / 2};
  }
  /// The camera of a level of an image pyramid, where level 0 has full resolution.
  PinholeParams at_level(int level) const {
    PinholeParams camera = *this;
    for (int i = 0; i < level; ++i) camera = camera.half();
    return camera;
  }
  int64_t pixel_count() const { return int64_t{width} * height; }
};

/// Pixels i to i + kLanes - 1 of an image, row by row.
template <int kLanes>
struct PixelsOf {
  int32_t u[kLanes], v[kLanes];

  KT_HOST_DEVICE PixelsOf(int64_t i, int32_t width) {
    const int32_t u0 = static_cast<int32_t>(i % width), v0 = static_cast<int32_t>(i / width);
    const float per_row = 1.0f / static_cast<float>(width);
    for (int l = 0; l < kLanes; ++l) {
      // Rows below the first; half a pixel keeps rounding from mattering.
      const auto rows = static_cast<int32_t>((static_cast<float>(u0 + l) + 0.5f) * per_row);
      u[l] = u0 + l - rows * width;
      v[l] = v0 + rows;
    }
  }
};

/// A pinhole with Brown-Conrady distortion {k1, k2, p1, p2, k3}: how points map to pixels of the image as
/// recorded.
struct DistortedPinholeParams {
  PinholeParams pinhole;
  float k1 = 0, k2 = 0, p1 = 0, p2 = 0, k3 = 0;

  /// Pixel of a point in the camera frame; needs p.z > 0.
  KT_HOST_DEVICE void project(Vec3f p, float* u, float* v) const {
    const float x = p.x / p.z, y = p.y / p.z;
    const float r2 = x * x + y * y;
    const float radial = 1.0f + r2 * (k1 + r2 * (k2 + r2 * k3));
    *u = pinhole.fx * (x * radial + 2.0f * p1 * x * y + p2 * (r2 + 2.0f * x * x)) + pinhole.cx;
    *v = pinhole.fy * (y * radial + p1 * (r2 + 2.0f * y * y) + 2.0f * p2 * x * y) + pinhole.cy;
  }
};

}  // namespace kt
