// Kernels that look at the measured surface: normals, trust of a pixel, registered colour.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "onboard/preprocess/depth_map.h"
#include "shared/core/image.h"
#include "shared/core/pinhole.h"

namespace kt {

/// Normal of the filtered depth at a pixel from central differences over `step` pixels (one-sided beside a
/// hole or an edge).
struct ComputeNormal {
  DepthView depth;
  PinholeParams camera;
  int32_t step;     // px, at most kDepthBorder
  float max_slope;  // |dz| per metre of range and pixel of step beyond which a neighbour lies on another
                    // surface
  Vec4f* normals;   // out: unit normal in the camera frame facing the camera; w = 1 where valid, else all 0

  KT_HOST_DEVICE Vec3f point(int u, int v, float z) const {
    return camera.unproject(static_cast<float>(u), static_cast<float>(v), z);
  }

  KT_HOST_DEVICE bool tangent(int u, int v, int du, int dv, float z, Vec3f* direction) const {
    const float limit = max_slope * z * static_cast<float>(step) + 3.0f * depth_sigma_m(z);
    const float ahead = depth.at(u + du, v + dv), behind = depth.at(u - du, v - dv);
    const bool has_ahead = ahead > 0.0f && fabsf(ahead - z) <= limit;
    const bool has_behind = behind > 0.0f && fabsf(behind - z) <= limit;
    if (!has_ahead && !has_behind) return false;
    const Vec3f a = has_ahead ? point(u + du, v + dv, ahead) : point(u, v, z);
    const Vec3f b = has_behind ? point(u - du, v - dv, behind) : point(u, v, z);
    *direction = a - b;
    return true;
  }

  KT_HOST_DEVICE void operator()(int u, int v) const {
    const float z = depth.at(u, v);
    Vec4f result;
    Vec3f along_u, along_v;
    if (z > 0.0f && tangent(u, v, step, 0, z, &along_u) && tangent(u, v, 0, step, z, &along_v)) {
      const Vec3f n = cross(along_v, along_u);  // u right, v down: points back to the camera
      const float length = norm(n);
      if (length > 0.0f) result = {n.x / length, n.y / length, n.z / length, 1.0f};
    }
    normals[int64_t{v} * camera.width + u] = result;
  }
};

/// What fusion reads of one depth pixel, in one 16-byte slot.
struct alignas(16) FusionPixel {
  float depth_m = 0;  ///< undistorted, unfiltered; 0 = none
  float distance_scale =
      0;              ///< distance to the surface's tangent plane per metre of depth difference along the ray
  float weight = 0;   ///< trust, 1 = head-on at 1 m; 0 = do not fuse
  uint32_t rgba = 0;  ///< colour registered to this pixel, r in the low byte; a = 0 where there is none
};

/// Trust of a measurement: falls with 1/z^2 (noise) and with the angle of view, zero at depth edges and
/// grazing angles.
struct MakeFusionPixel {
  DepthView depth;  // unfiltered
  PinholeParams camera;
  const Vec4f* normals;    // of the filtered depth
  float min_cosine;        // grazing limit
  float max_slope;         // as in ComputeNormal: a larger jump is a depth edge
  const uint32_t* colour;  // registered, or null
  FusionPixel* pixels;     // out

  KT_HOST_DEVICE bool is_depth_edge(int u, int v, float z) const {
    constexpr int kReach = 2;
    const float limit = max_slope * z * kReach + 3.0f * depth_sigma_m(z);
    for (int dv = -kReach; dv <= kReach; dv += kReach) {
      for (int du = -kReach; du <= kReach; du += kReach) {
        const float other = depth.at(u + du, v + dv);
        if (other > 0.0f && fabsf(other - z) > limit) return true;
      }
    }
    return false;
  }

  KT_HOST_DEVICE void operator()(int u, int v) const {
    const int64_t i = int64_t{v} * camera.width + u;
    FusionPixel pixel;
    pixel.depth_m = depth.at(u, v);
    pixel.rgba = colour ? colour[i] : 0u;
    const Vec4f n = normals[i];
    if (pixel.depth_m > 0.0f && n.w > 0.0f) {
      const Vec3f ray = camera.unproject(static_cast<float>(u), static_cast<float>(v), 1.0f);
      const float scale = -dot(xyz(n), ray);
      const float cosine = scale / norm(ray);
      if (cosine >= min_cosine && !is_depth_edge(u, v, pixel.depth_m)) {
        const float z = max_of(pixel.depth_m, 1.0f);
        pixel.distance_scale = scale;
        pixel.weight = cosine / (z * z);
      }
    }
    pixels[i] = pixel;
  }
};

/// Colour of each depth pixel: its point projected into the colour camera, bilinear.
struct RegisterColour {
  DepthView depth;       // filtered: fewer speckles than the raw depth gives
  PinholeParams camera;  // of the depth
  Rigid3f T_colour_depth;
  DistortedPinholeParams colour_camera;
  const Rgb8* colour;    // as recorded
  uint32_t* registered;  // out, rgba

  KT_HOST_DEVICE void operator()(int u, int v) const {
    const float z = depth.at(u, v);
    uint32_t rgba = 0;
    if (z > 0.0f) {
      const Vec3f p = T_colour_depth * camera.unproject(static_cast<float>(u), static_cast<float>(v), z);
      float cu = -1.0f, cv = -1.0f;
      if (p.z > 0.0f) colour_camera.project(p, &cu, &cv);
      const PinholeParams& size = colour_camera.pinhole;
      if (cu >= 0.0f && cv >= 0.0f && cu < static_cast<float>(size.width - 1) &&
          cv < static_cast<float>(size.height - 1)) {
        const int u0 = static_cast<int>(cu), v0 = static_cast<int>(cv);
        const float fu = cu - static_cast<float>(u0), fv = cv - static_cast<float>(v0);
        const Rgb8* row0 = colour + int64_t{v0} * size.width + u0;
        const Rgb8* row1 = row0 + size.width;
        const float w00 = (1.0f - fu) * (1.0f - fv), w10 = fu * (1.0f - fv), w01 = (1.0f - fu) * fv,
                    w11 = fu * fv;
        const float r = w00 * row0[0].r + w10 * row0[1].r + w01 * row1[0].r + w11 * row1[1].r;
        const float g = w00 * row0[0].g + w10 * row0[1].g + w01 * row1[0].g + w11 * row1[1].g;
        const float b = w00 * row0[0].b + w10 * row0[1].b + w01 * row1[0].b + w11 * row1[1].b;
        rgba = static_cast<uint32_t>(r + 0.5f) | static_cast<uint32_t>(g + 0.5f) << 8 |
               static_cast<uint32_t>(b + 0.5f) << 16 | 0xff000000u;
      }
    }
    registered[int64_t{v} * camera.width + u] = rgba;
  }
};

}  // namespace kt
