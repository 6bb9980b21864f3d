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

  KT_HOST_DEVICE void operator()(int u, int v) const { lanes<1>(u, v); }

  template <int kLanes>
  KT_HOST_DEVICE void lanes(int u, int v) const {
    const float* here = depth.depth_m + depth.index(u, v);
    const float* above = depth.depth_m + depth.index(u, v - step);
    const float* below = depth.depth_m + depth.index(u, v + step);
    const float reach = static_cast<float>(step);
    const float reach_x = reach / camera.fx, reach_y = reach / camera.fy;
    const float ray_y = (static_cast<float>(v) - camera.cy) / camera.fy;
    Vec3fs<kLanes> n;
    float valid[kLanes];
    for (int l = 0; l < kLanes; ++l) {
      const float z = here[l];
      const float limit = max_slope * z * reach + 3.0f * depth_sigma_m(z);
      const float ray_x = (static_cast<float>(u + l) - camera.cx) / camera.fx;
      const Difference along_u = difference(here[l + step], here[l - step], z, limit),
                       along_v = difference(below[l], above[l], z, limit);
      const Vec3f tangent_u{ray_x * along_u.dz + reach_x * along_u.z_sum, ray_y * along_u.dz, along_u.dz};
      const Vec3f tangent_v{ray_x * along_v.dz, ray_y * along_v.dz + reach_y * along_v.z_sum, along_v.dz};
      const Vec3f normal = cross(tangent_v, tangent_u);  // u right, v down: points back to the camera
      const float length = norm(normal);
      const int32_t is_valid = (z > 0.0f) & along_u.kept & along_v.kept & (length > 0.0f);
      const float inverse = 1.0f / (is_valid ? length : 1.0f);
      valid[l] = is_valid ? 1.0f : 0.0f;
      n.set(l, normal * (is_valid ? inverse : 0.0f));
    }
    Vec4f* out = normals + int64_t{v} * camera.width + u;
    for (int l = 0; l < kLanes; ++l) out[l] = {n.x[l], n.y[l], n.z[l], valid[l]};
  }

 private:
  // Between the points ahead and behind of a pixel, of which those beside a hole or an edge are replaced by
  // the pixel itself: depth difference, the sum of the depths of those kept, by which the distance across
  // grows, and whether there is one.
  struct Difference {
    float dz, z_sum;
    int32_t kept;
  };
  KT_HOST_DEVICE static Difference difference(float ahead, float behind, float z, float limit) {
    const int32_t has_ahead = (ahead > 0.0f) & (fabsf(ahead - z) <= limit),
                  has_behind = (behind > 0.0f) & (fabsf(behind - z) <= limit);
    return {(has_ahead ? ahead : z) - (has_behind ? behind : z),
            (has_ahead ? ahead : 0.0f) + (has_behind ? behind : 0.0f), has_ahead | has_behind};
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

  KT_HOST_DEVICE void operator()(int u, int v) const { lanes<1>(u, v); }

  template <int kLanes>
  KT_HOST_DEVICE void lanes(int u, int v) const {
    constexpr int kReach = 2;
    const float* here = depth.depth_m + depth.index(u, v);
    const float* above = depth.depth_m + depth.index(u, v - kReach);
    const float* below = depth.depth_m + depth.index(u, v + kReach);
    const int64_t i = int64_t{v} * camera.width + u;
    const float ray_y = (static_cast<float>(v) - camera.cy) / camera.fy;
    Vec3fs<kLanes> n;
    float valid[kLanes], z[kLanes];
    uint32_t packed[kLanes];
    for (int l = 0; l < kLanes; ++l) {
      const Vec4f normal = normals[i + l];
      n.set(l, xyz(normal));
      valid[l] = normal.w;
    }
    for (int l = 0; l < kLanes; ++l) {
      z[l] = here[l];
      const float limit = max_slope * z[l] * kReach + 3.0f * depth_sigma_m(z[l]);
      const auto is_edge = [&](const float* row, int at) {
        return static_cast<int32_t>((row[at] > 0.0f) & (fabsf(row[at] - z[l]) > limit));
      };
      int32_t edge = 0;
      KT_UNROLL for (int at = -kReach; at <= kReach; at += kReach) {
        edge |= is_edge(above, l + at) | is_edge(here, l + at) | is_edge(below, l + at);
      }
      const Vec3f ray{(static_cast<float>(u + l) - camera.cx) / camera.fx, ray_y, 1.0f};
      const float scale = -dot(n.at(l), ray);
      const float cosine = scale / norm(ray);
      const int32_t trusted = (z[l] > 0.0f) & (valid[l] > 0.0f) & (cosine >= min_cosine) & (edge == 0);
      const float far = max_of(z[l], 1.0f);
      packed[l] = FusionPixel::packed(trusted ? min_of(scale, FusionPixel::kLargestScale) : 0.0f,
                                      trusted ? cosine / (far * far) : 0.0f);
    }
    for (int l = 0; l < kLanes; ++l) pixels[i + l] = {z[l], packed[l]};
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

  KT_HOST_DEVICE void operator()(int u, int v) const { lanes<1>(u, v); }

  template <int kLanes>
  KT_HOST_DEVICE void lanes(int u, int v) const {
    const int64_t i = int64_t{v} * depth.width + u;
    const float* z = depth.depth_m + depth.index(u, v);
    const auto last_u = static_cast<float>(colour_width - 1), last_v = static_cast<float>(colour_height - 1);
    float fu[kLanes], fv[kLanes];
    int32_t seen[kLanes], at[kLanes], right[kLanes], below[kLanes];
    for (int l = 0; l < kLanes; ++l) {
      const ColourPosition position = positions[i + l];
      seen[l] = (z[l] > 0.0f) & (position.u >= 0.0f) & (position.v >= 0.0f) & (position.u <= last_u) &
                (position.v <= last_v);
      const float at_u = seen[l] ? position.u : 0.0f, at_v = seen[l] ? position.v : 0.0f;
      const auto u0 = static_cast<int32_t>(at_u), v0 = static_cast<int32_t>(at_v);
      fu[l] = at_u - static_cast<float>(u0);
      fv[l] = at_v - static_cast<float>(v0);
      at[l] = v0 * colour_width + u0;
      right[l] = u0 + 1 < colour_width ? 1 : 0;
      below[l] = v0 + 1 < colour_height ? colour_width : 0;
    }
    uint32_t corners[4][kLanes];
    for (int l = 0; l < kLanes; ++l) corners[0][l] = colour[at[l]].packed();
    for (int l = 0; l < kLanes; ++l) corners[1][l] = colour[at[l] + right[l]].packed();
    for (int l = 0; l < kLanes; ++l) corners[2][l] = colour[at[l] + below[l]].packed();
    for (int l = 0; l < kLanes; ++l) corners[3][l] = colour[at[l] + below[l] + right[l]].packed();
    uint32_t rgba[kLanes];
    for (int l = 0; l < kLanes; ++l) {
      const float w00 = (1.0f - fu[l]) * (1.0f - fv[l]), w10 = fu[l] * (1.0f - fv[l]),
                  w01 = (1.0f - fu[l]) * fv[l], w11 = fu[l] * fv[l];
      const auto blend = [&](int shift) {
        const auto level = [&](int corner) {
          return static_cast<float>(static_cast<int32_t>(corners[corner][l] >> shift & 255));
        };
        const float mean = w00 * level(0) + w10 * level(1) + w01 * level(2) + w11 * level(3);
        return static_cast<uint32_t>(static_cast<int32_t>(mean + 0.5f)) << shift;
      };
      rgba[l] = seen[l] ? blend(0) | blend(8) | blend(16) | 0xff000000u : 0u;
    }
    for (int l = 0; l < kLanes; ++l) registered[i + l] = rgba[l];
  }
};

}  // namespace kt
