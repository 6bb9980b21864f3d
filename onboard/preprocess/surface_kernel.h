// Kernels that look at the measured surface: normals, trust of a pixel, registered colour.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "onboard/preprocess/depth_map.h"
#include "shared/core/image.h"
#include "shared/core/pinhole.h"

namespace kt {

/// Normal of the filtered depth at a pixel from central differences over `step` pixels (one-sided beside a
/// hole or an edge). Free of branches, so that a row of pixels becomes SIMD.
struct ComputeNormal {
  DepthView depth;
  PinholeParams camera;
  int32_t step;     // px, at most kDepthBorder
  float max_slope;  // |dz| per metre of range and pixel of step beyond which a neighbour lies on another
                    // surface
  Vec4f* normals;   // out: unit normal in the camera frame facing the camera; w = 1 where valid, else all 0

  KT_HOST_DEVICE void operator()(int u, int v) const {
    const float z = depth.at(u, v);
    const float limit = max_slope * z * static_cast<float>(step) + 3.0f * depth_sigma_m(z);
    const float ray_x = (static_cast<float>(u) - camera.cx) / camera.fx,
                ray_y = (static_cast<float>(v) - camera.cy) / camera.fy;
    const Difference along_u = difference(depth.at(u + step, v), depth.at(u - step, v), z, limit),
                     along_v = difference(depth.at(u, v + step), depth.at(u, v - step), z, limit);
    const float reach_x = static_cast<float>(step) / camera.fx,
                reach_y = static_cast<float>(step) / camera.fy;
    const Vec3f tangent_u{ray_x * along_u.dz + reach_x * along_u.z_sum, ray_y * along_u.dz, along_u.dz};
    const Vec3f tangent_v{ray_x * along_v.dz, ray_y * along_v.dz + reach_y * along_v.z_sum, along_v.dz};
    const Vec3f n = cross(tangent_v, tangent_u);  // u right, v down: points back to the camera
    const float length = norm(n);
    const float valid =
        (z > 0.0f) & (along_u.z_sum > 0.0f) & (along_v.z_sum > 0.0f) & (length > 0.0f) ? 1.0f : 0.0f;
    const float scale = valid / (length > 0.0f ? length : 1.0f);
    normals[int64_t{v} * camera.width + u] = {n.x * scale, n.y * scale, n.z * scale, valid};
  }

 private:
  // Between the points ahead and behind of a pixel, of which those beside a hole or an edge are replaced by
  // the pixel itself: depth difference, and the sum of the depths of those kept, by which the distance across
  // grows.
  struct Difference {
    float dz, z_sum;
  };
  KT_HOST_DEVICE static Difference difference(float ahead, float behind, float z, float limit) {
    const bool has_ahead = (ahead > 0.0f) & (fabsf(ahead - z) <= limit),
               has_behind = (behind > 0.0f) & (fabsf(behind - z) <= limit);
    return {(has_ahead ? ahead : z) - (has_behind ? behind : z),
            (has_ahead ? ahead : 0.0f) + (has_behind ? behind : 0.0f)};
  }
};

/// What fusion reads of one depth pixel, in 8 bytes: a frame's pixels are looked up from the cache.
struct alignas(8) FusionPixel {
  static constexpr float kScaleUnits = 16384.0f;  ///< of scale 1
  static constexpr float kWeightUnits = 128.0f;   ///< of weight 1
  static constexpr float kLargestScale = 3.99f;

  float depth_m = 0;              ///< undistorted, unfiltered; 0 = none
  uint32_t scale_and_weight = 0;  ///< units of both, the scale in the upper half

  /// Scale in [0, kLargestScale], weight in [0, 1].
  KT_HOST_DEVICE static uint32_t packed(float scale, float weight) {
    // By way of int32: SIMD has no other conversion.
    return static_cast<uint32_t>(static_cast<int32_t>(scale * kScaleUnits + 0.5f)) << 16 |
           static_cast<uint32_t>(static_cast<int32_t>(weight * kWeightUnits + 0.5f));
  }
  /// Distance to the surface's tangent plane per metre of depth difference along the ray.
  KT_HOST_DEVICE static float scale_of(uint32_t packed) {
    return static_cast<float>(static_cast<int32_t>(packed >> 16)) * (1.0f / kScaleUnits);
  }
  KT_HOST_DEVICE static int32_t weight_units_of(uint32_t packed) {
    return static_cast<int32_t>(packed & 0xffff);
  }
  KT_HOST_DEVICE float distance_scale() const { return scale_of(scale_and_weight); }
  KT_HOST_DEVICE int32_t weight_units() const { return weight_units_of(scale_and_weight); }
  /// Trust, 1 = head-on at 1 m; 0 = do not fuse.
  KT_HOST_DEVICE float weight() const { return static_cast<float>(weight_units()) / kWeightUnits; }
};

/// Trust of a measurement: falls with 1/z^2 (noise) and with the angle of view, zero at depth edges and
/// grazing angles.
struct MakeFusionPixel {
  DepthView depth;  // unfiltered
  PinholeParams camera;
  const Vec4f* normals;  // of the filtered depth
  float min_cosine;      // grazing limit
  float max_slope;       // as in ComputeNormal: a larger jump is a depth edge
  FusionPixel* pixels;   // out

  /// Free of branches, so that a row of pixels becomes SIMD.
  KT_HOST_DEVICE void operator()(int u, int v) const {
    const int64_t i = int64_t{v} * camera.width + u;
    const float z = depth.at(u, v);
    const Vec4f n = normals[i];
    const Vec3f ray = camera.unproject(static_cast<float>(u), static_cast<float>(v), 1.0f);
    const float scale = -dot(xyz(n), ray);
    const float cosine = scale / norm(ray);
    const bool trusted = (z > 0.0f) & (n.w > 0.0f) & (cosine >= min_cosine) & !is_depth_edge(u, v, z);
    const float far = max_of(z, 1.0f);
    pixels[i] = {z, FusionPixel::packed(trusted ? min_of(scale, FusionPixel::kLargestScale) : 0.0f,
                                        trusted ? cosine / (far * far) : 0.0f)};
  }

 private:
  KT_HOST_DEVICE bool is_depth_edge(int u, int v, float z) const {
    constexpr int kReach = 2;
    const float limit = max_slope * z * kReach + 3.0f * depth_sigma_m(z);
    int edge = 0;
    KT_UNROLL for (int dv = -kReach; dv <= kReach; dv += kReach) {
      KT_UNROLL for (int du = -kReach; du <= kReach; du += kReach) {
        const float other = depth.at(u + du, v + dv);
        edge |= (other > 0.0f) & (fabsf(other - z) > limit);
      }
    }
    return edge != 0;
  }
};

/// Where a depth pixel's point is seen in the colour image as recorded.
struct ColourPosition {
  float u = -1, v = -1;  // px; outside the image where the pixel has no depth or is hidden from the camera
};

struct FindColourPosition {
  DepthView depth;       // filtered: fewer speckles than the raw depth gives
  PinholeParams camera;  // of the depth
  Rigid3f T_colour_depth;
  DistortedPinholeParams colour_camera;
  ColourPosition* positions;  // out

  KT_HOST_DEVICE void operator()(int u, int v) const {
    const float z = depth.at(u, v);
    const Vec3f p = T_colour_depth * camera.unproject(static_cast<float>(u), static_cast<float>(v), z);
    const bool in_front = (z > 0.0f) & (p.z > 0.0f);
    ColourPosition position;
    colour_camera.project({p.x, p.y, in_front ? p.z : 1.0f}, &position.u, &position.v);
    positions[int64_t{v} * camera.width + u] = {in_front ? position.u : -1.0f, in_front ? position.v : -1.0f};
  }
};

/// Colour of each depth pixel, bilinear.
struct SampleColour {
  DepthView depth;
  const ColourPosition* positions;
  int32_t colour_width, colour_height;
  const Rgb8* colour;    // as recorded
  uint32_t* registered;  // out, rgba

  KT_HOST_DEVICE void operator()(int u, int v) const {
    const int64_t i = int64_t{v} * depth.width + u;
    const auto [cu, cv] = positions[i];
    uint32_t rgba = 0;
    if (depth.at(u, v) > 0.0f && cu >= 0.0f && cv >= 0.0f && cu <= static_cast<float>(colour_width - 1) &&
        cv <= static_cast<float>(colour_height - 1)) {
      const int u0 = static_cast<int>(cu), v0 = static_cast<int>(cv);
      const float fu = cu - static_cast<float>(u0), fv = cv - static_cast<float>(v0);
      const Rgb8* row0 = colour + int64_t{v0} * colour_width + u0;
      const int right = u0 + 1 < colour_width ? 1 : 0;
      const Rgb8* row1 = v0 + 1 < colour_height ? row0 + colour_width : row0;
      const float w00 = (1.0f - fu) * (1.0f - fv), w10 = fu * (1.0f - fv), w01 = (1.0f - fu) * fv,
                  w11 = fu * fv;
      const auto blend = [&](uint8_t a, uint8_t b, uint8_t c, uint8_t d) {
        return static_cast<uint32_t>(w00 * a + w10 * b + w01 * c + w11 * d + 0.5f);
      };
      rgba = blend(row0[0].r, row0[right].r, row1[0].r, row1[right].r) |
             blend(row0[0].g, row0[right].g, row1[0].g, row1[right].g) << 8 |
             blend(row0[0].b, row0[right].b, row1[0].b, row1[right].b) << 16 | 0xff000000u;
    }
    registered[i] = rgba;
  }
};

}  // namespace kt
