// Kernels that find the depth pixels whose points something nearer hides from the colour camera.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "onboard/preprocess/surface_kernel.h"

namespace kt {

/// Nearest depth (m) of a tile of pixels, kNone where it has no depth.
struct NearestInTile {
  static constexpr int kSide = 16;  // px
  static constexpr float kNone = 1e9f;
  DepthView depth;
  float* nearest_m;  // out, tiles(width) per row

  KT_HOST_DEVICE static int tiles(int pixels) { return (pixels + kSide - 1) / kSide; }

  KT_HOST_DEVICE void operator()(int tile_u, int tile_v) const {
    const int u0 = tile_u * kSide, columns = depth.width - u0 < kSide ? depth.width - u0 : kSide;
    float nearest[kSide];
    for (int k = 0; k < kSide; ++k) nearest[k] = kNone;
    for (int v = tile_v * kSide; v < (tile_v + 1) * kSide && v < depth.height; ++v) {
      for (int k = 0; k < columns; ++k) {
        const float z = depth.at(u0 + k, v);
        nearest[k] = z > 0.0f ? min_of(nearest[k], z) : nearest[k];
      }
    }
    for (int k = 1; k < kSide; ++k) nearest[0] = min_of(nearest[0], nearest[k]);
    nearest_m[int64_t{tile_v} * tiles(depth.width) + tile_u] = nearest[0];
  }
};

/// Takes the colour position from pixels whose point a nearer measured surface hides from the colour camera.
/// An element is the part of an image row within one tile.
///
/// On the way from a pixel's point (pixel x, inverse depth w) to the colour camera's centre c, pixel and
/// inverse depth are linear in one parameter s:
///   x(s) = x + s e,  e = (fx c.x - c.z (u - cx), fy c.y - c.z (v - cy)),  w(s) = w + s (1 - c.z w).
/// The walk takes steps of one pixel along the longer component of e. The surface measured at the pixel of
/// step k has, against the point and against the way,
///   parallax = (1 / z_k - w) |e| / (1 - c.z w),  lead = parallax - k   (px).
/// Where the lead is positive the way passes behind that surface, where it is zero it goes through it. Over a
/// surface that the colour camera sees, the lead falls with every step, however slanted it is: only a step up
/// to another surface, or one seen from behind, makes it rise. The point is hidden if from there on a nearer
/// surface comes within kBeside of the way.
struct HideFromColour {
  DepthView depth;  // the one that colour positions were found for
  PinholeParams camera;
  Vec3f centre;               // of the colour camera in the depth camera's frame
  float min_m;                // there is no nearer depth
  const float* nearest_m;     // by tile
  ColourPosition* positions;  // in and out

  KT_HOST_DEVICE void operator()(int tile_u, int v) const {
    constexpr int kSide = NearestInTile::kSide;
    const int u0 = tile_u * kSide, columns = depth.width - u0 < kSide ? depth.width - u0 : kSide;
    const float nearest = nearest_ahead(u0, u0 + columns - 1, v);
    float reach[kSide];
    for (int k = 0; k < columns; ++k) reach[k] = parallax(u0 + k, v, depth.at(u0 + k, v), nearest);
    for (int k = 0; k < columns; ++k) {
      if (reach[k] > 1.0f + kRounding && is_hidden(u0 + k, v, reach[k])) {
        positions[int64_t{v} * camera.width + u0 + k] = {};
      }
    }
  }

 private:
  static constexpr float kRounding = 0.5f;  // px, of where the way goes
  // px: the edge of a surface lies up to one beyond its last pixel, and the bilinear look-up reaches one.
  static constexpr float kBeside = 2.0f;

  struct Direction {
    float u, v;
    KT_HOST_DEVICE float longer() const { return max_of(fabsf(u), fabsf(v)); }
  };

  KT_HOST_DEVICE Direction direction(int u, int v) const {
    return {camera.fx * centre.x - centre.z * (static_cast<float>(u) - camera.cx),
            camera.fy * centre.y - centre.z * (static_cast<float>(v) - camera.cy)};
  }

  // Of a surface at depth `other` against a pixel at depth z; 0 where it has none or is behind the centre.
  KT_HOST_DEVICE float parallax(int u, int v, float z, float other) const {
    const float w = 1.0f / max_of(z, 1e-3f), rise = 1.0f - centre.z * w;
    const float value = (1.0f / other - w) * direction(u, v).longer() / max_of(rise, 1e-3f);
    return (z > 0.0f) & (rise > 0.0f) ? value : 0.0f;
  }

  // Nearest depth of all tiles that the ways of pixels u0 to u1 of row v can cross: from the nearest possible
  // depth follows how far a way may go, from the nearest depth found there how far it need be followed.
  KT_HOST_DEVICE float nearest_ahead(int u0, int u1, int v) const {
    constexpr auto kSide = static_cast<float>(NearestInTile::kSide);
    const Direction at_u0 = direction(u0, v), at_u1 = direction(u1, v);
    const float last_u = static_cast<float>(depth.width - 1), last_v = static_cast<float>(depth.height - 1);
    const float first = max_of(min_m, centre.z);
    float nearest = first;
    for (int pass = 0; pass < 2; ++pass) {
      const float s =
          1.0f / nearest;  // where a way from infinitely far gets to that depth, the others sooner
      const float low_u =
                      static_cast<float>(u0) + s * min_of(min_of(at_u0.u, at_u1.u), 0.0f) - kBeside - 1.0f,
                  high_u =
                      static_cast<float>(u1) + s * max_of(max_of(at_u0.u, at_u1.u), 0.0f) + kBeside + 1.0f,
                  low_v = static_cast<float>(v) + s * min_of(min_of(at_u0.v, at_u1.v), 0.0f) - kBeside - 1.0f,
                  high_v =
                      static_cast<float>(v) + s * max_of(max_of(at_u0.v, at_u1.v), 0.0f) + kBeside + 1.0f;
      const int tile_u0 = static_cast<int>(max_of(low_u, 0.0f) / kSide),
                tile_u1 = static_cast<int>(min_of(high_u, last_u) / kSide),
                tile_v0 = static_cast<int>(max_of(low_v, 0.0f) / kSide),
                tile_v1 = static_cast<int>(min_of(high_v, last_v) / kSide);
      nearest = NearestInTile::kNone;
      for (int tile_v = tile_v0; tile_v <= tile_v1; ++tile_v) {
        const float* row = nearest_m + int64_t{tile_v} * NearestInTile::tiles(depth.width);
        for (int tile_u = tile_u0; tile_u <= tile_u1; ++tile_u) nearest = min_of(nearest, row[tile_u]);
      }
      nearest = max_of(nearest, first);
    }
    return nearest;
  }

  // `reach` is the largest parallax on the way.
  KT_HOST_DEVICE bool is_hidden(int u, int v, float reach) const {
    const float z = depth.at(u, v), w = 1.0f / z;
    const Direction e = direction(u, v);
    const float scale = e.longer() / (1.0f - centre.z * w);
    const float step_u = e.u / e.longer(), step_v = e.v / e.longer();
    const float margin = kRounding + 3.0f * depth_sigma_m(z) * w * w * scale;
    bool meets_other = false;
    float last_lead = 0.0f;
    for (float k = 1.0f; k <= reach + kBeside; k += 1.0f) {
      const float at_u = static_cast<float>(u) + k * step_u + 0.5f,
                  at_v = static_cast<float>(v) + k * step_v + 0.5f;
      if (!(at_u >= 0.0f && at_v >= 0.0f && at_u < static_cast<float>(depth.width) &&
            at_v < static_cast<float>(depth.height)))
        return false;
      const float z_k = depth.at(static_cast<int>(at_u), static_cast<int>(at_v));
      if (z_k <= 0.0f) continue;  // a hole hides nothing
      const float parallax_k = (1.0f / z_k - w) * scale, lead = parallax_k - k;
      if (lead >= margin || lead - last_lead >= 2.0f * margin) meets_other = true;
      if (meets_other && parallax_k >= margin && fabsf(lead) <= kBeside) return true;
      last_lead = lead;
    }
    return false;
  }
};

}  // namespace kt
