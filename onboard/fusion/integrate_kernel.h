// Kernels that fuse one frame into the volume.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "onboard/fusion/grid.h"
#include "onboard/preprocess/surface_kernel.h"
#include "shared/core/pinhole.h"

namespace kt {

/// Nearest and farthest fusable depth of a tile of pixels; nearest > farthest where there is none.
struct DepthRange {
  float nearest_m = 1e9f, farthest_m = 0.0f;
};
inline constexpr int kTileSide = 16;  // px

struct TileDepthRange {
  const FusionPixel* pixels;
  int32_t width, height;
  DepthRange* tiles;  // out, ceil(width / kTileSide) per row

  KT_HOST_DEVICE void operator()(int tile_u, int tile_v) const {
    DepthRange range;
    const int tiles_per_row = (width + kTileSide - 1) / kTileSide;
    for (int v = tile_v * kTileSide; v < (tile_v + 1) * kTileSide && v < height; ++v) {
      for (int u = tile_u * kTileSide; u < (tile_u + 1) * kTileSide && u < width; ++u) {
        const FusionPixel& pixel = pixels[int64_t{v} * width + u];
        if (pixel.weight <= 0.0f) continue;
        range.nearest_m = min_of(range.nearest_m, pixel.depth_m);
        range.farthest_m = max_of(range.farthest_m, pixel.depth_m);
      }
    }
    tiles[int64_t{tile_v} * tiles_per_row + tile_u] = range;
  }
};

/// Flags the bricks that a frame changes: those that its truncation band may reach, and those that hold
/// surface where it sees through. By block of bricks, so that what lies outside the view costs little.
struct SelectBlock {
  VolumeView volume;
  PinholeParams camera;
  Rigid3f T_camera_volume;
  const DepthRange* tiles;
  uint8_t* selected;  // out, by slot

  static int64_t element_count(int bricks) {
    const int64_t blocks = bricks / kBlockSide;
    return blocks * blocks * blocks;
  }

  KT_HOST_DEVICE void operator()(int64_t block) const {
    const int blocks = volume.bricks / kBlockSide;
    const Vec3i low{static_cast<int32_t>(block % blocks) * kBlockSide,
                    static_cast<int32_t>(block / blocks % blocks) * kBlockSide,
                    static_cast<int32_t>(block / blocks / blocks) * kBlockSide};
    const bool visible = can_be_seen(sphere(low, kBlockSide));
    for (int k = 0; k < kBlockSide * kBlockSide * kBlockSide; ++k) {
      const Vec3i b = low + Vec3i{k % kBlockSide, k / kBlockSide % kBlockSide, k / kBlockSide / kBlockSide};
      const int64_t slot = volume.slot(b);
      selected[slot] = visible && changes(sphere(b, 1), volume.brick_states[slot] == kBrickSurface) ? 1 : 0;
    }
  }

 private:
  struct Sphere {
    Vec3f p;  // centre in the camera frame (m)
    float radius;
  };

  // Around the voxel centres of the cube of `side` bricks whose lowest is b.
  KT_HOST_DEVICE Sphere sphere(Vec3i b, int side) const {
    const float half = 0.5f * static_cast<float>(side * kBrickSide - 1);
    const Vec3f centre{static_cast<float>(b.x * kBrickSide) + half,
                       static_cast<float>(b.y * kBrickSide) + half,
                       static_cast<float>(b.z * kBrickSide) + half};
    return {T_camera_volume * (centre * volume.voxel_size_m), 1.7320508f * half * volume.voxel_size_m};
  }

  // False only where no point of the sphere can be in the image: it lies behind one of the five planes that
  // bound the view.
  KT_HOST_DEVICE bool can_be_seen(Sphere s) const {
    const float left = camera.cx + 0.5f, right = static_cast<float>(camera.width) - 0.5f - camera.cx,
                top = camera.cy + 0.5f, bottom = static_cast<float>(camera.height) - 0.5f - camera.cy;
    const auto outside = [&s](float focal, float edge, float across) {
      return focal * across + edge * s.p.z < -s.radius * sqrtf(focal * focal + edge * edge);
    };
    return s.p.z + s.radius >= 0.0f && !outside(camera.fx, left, s.p.x) &&
           !outside(camera.fx, right, -s.p.x) && !outside(camera.fy, top, s.p.y) &&
           !outside(camera.fy, bottom, -s.p.y);
  }

  KT_HOST_DEVICE bool changes(Sphere s, bool holds_surface) const {
    if (s.p.z + s.radius < 0.1f) return false;
    // Bounding box of the sphere in the image, generous near the camera.
    const float nearest_z = max_of(s.p.z - s.radius, 0.1f);
    const float reach_u = s.radius / nearest_z * camera.fx, reach_v = s.radius / nearest_z * camera.fy;
    const float scale = 1.0f / max_of(s.p.z, 0.1f);
    const float u = s.p.x * scale * camera.fx + camera.cx, v = s.p.y * scale * camera.fy + camera.cy;
    const float u0 = max_of(u - reach_u, 0.0f),
                u1 = min_of(u + reach_u, static_cast<float>(camera.width - 1));
    const float v0 = max_of(v - reach_v, 0.0f),
                v1 = min_of(v + reach_v, static_cast<float>(camera.height - 1));
    if (u0 > u1 || v0 > v1) return false;
    const int tiles_per_row = (camera.width + kTileSide - 1) / kTileSide;
    DepthRange range;
    for (int tv = static_cast<int>(v0) / kTileSide; tv <= static_cast<int>(v1) / kTileSide; ++tv) {
      for (int tu = static_cast<int>(u0) / kTileSide; tu <= static_cast<int>(u1) / kTileSide; ++tu) {
        const DepthRange tile = tiles[int64_t{tv} * tiles_per_row + tu];
        range.nearest_m = min_of(range.nearest_m, tile.nearest_m);
        range.farthest_m = max_of(range.farthest_m, tile.farthest_m);
      }
    }
    // In front, twice the truncation distance along the ray: surfaces seen at up to 60 degrees.
    const bool reaches_surface = s.p.z + s.radius >= range.nearest_m - 2.0f * volume.truncation_m;
    const bool behind = s.p.z - s.radius > range.farthest_m + volume.truncation_m;
    return !behind && (reaches_surface || holds_surface);
  }
};

/// What fusing a frame left in a row of voxels.
enum RowFlag : uint8_t {
  kRowSurface = 1,  // a voxel near a surface
  kRowFused = 2,    // a voxel that the frame measured
};

/// Fuses a frame into one row of 8 voxels: weighted running average of the truncated signed distance to the
/// tangent plane of the measured surface (Curless and Levoy 1996; Newcombe et al. 2011, eq. 6 to 13) and of
/// the colour. Behind the measurement it reaches one truncation distance along the ray: farther off, the
/// tangent plane says nothing about the surface.
///   sdf = (depth - z) * distance_scale;  F' = (W F + w min(sdf / mu, 1)) / (W + w);  W' = min(W + w, W_max)
struct FuseRow {
  VolumeView volume;
  PinholeParams camera;
  Rigid3f T_camera_volume;
  const int32_t* slots;  // selected bricks
  const FusionPixel* pixels;
  float max_weight_units;
  uint8_t* row_flags;  // out, RowFlag

  /// Works on the eight voxels in steps that a compiler turns into SIMD; only the look-ups in between are one
  /// by one.
  KT_HOST_DEVICE void operator()(int64_t i) const {
    constexpr int kN = kBrickSide;
    const int64_t slot = slots[i / (kN * kN)];
    const int row = static_cast<int>(i % (kN * kN));
    const Vec3i b = volume.brick(slot);
    const int64_t first = slot * kBrickVoxels + row * kN;
    const Vec3f start =
        T_camera_volume * (Vec3f{static_cast<float>(b.x * kN), static_cast<float>(b.y * kN + row % kN),
                                 static_cast<float>(b.z * kN + row / kN)} *
                           volume.voxel_size_m);
    const Vec3f step =
        Vec3f{T_camera_volume.R.m[0], T_camera_volume.R.m[3], T_camera_volume.R.m[6]} * volume.voxel_size_m;

    // Pixel of each voxel, 0 where it is not seen.
    float z[kN];
    int32_t pixel_index[kN], seen[kN];
    const auto width = static_cast<float>(camera.width), height = static_cast<float>(camera.height);
    for (int x = 0; x < kN; ++x) {
      const auto offset = static_cast<float>(x);
      z[x] = start.z + step.z * offset;
      const float inverse_z = 1.0f / z[x];
      const float u = (start.x + step.x * offset) * inverse_z * camera.fx + camera.cx + 0.5f;
      const float v = (start.y + step.y * offset) * inverse_z * camera.fy + camera.cy + 0.5f;
      seen[x] = (z[x] >= 0.05f) & (u >= 0.0f) & (v >= 0.0f) & (u < width) & (v < height);
      pixel_index[x] =
          static_cast<int32_t>(seen[x] ? v : 0.0f) * camera.width + static_cast<int32_t>(seen[x] ? u : 0.0f);
    }
    float depth[kN], scale[kN], weight[kN];
    for (int x = 0; x < kN; ++x) {
      const FusionPixel& pixel = pixels[pixel_index[x]];
      depth[x] = pixel.depth_m;
      scale[x] = pixel.distance_scale;
      weight[x] = seen[x] ? pixel.weight : 0.0f;
    }

    int32_t distance[kN], old_weight[kN], frozen[kN];
    for (int x = 0; x < kN; ++x) {
      const Voxel voxel = volume.voxels[first + x];
      distance[x] = voxel.distance;
      old_weight[x] = voxel.weight_units();
      frozen[x] = voxel.is_frozen();
    }

    float sdf[kN], w_new[kN];
    int32_t fused[kN], new_weight[kN];
    int32_t any_fused = 0, near_surface = 0;
    for (int x = 0; x < kN; ++x) {
      sdf[x] = (depth[x] - z[x]) * scale[x];
      w_new[x] = floorf(weight[x] * Voxel::kWeightUnits + 0.5f);
      fused[x] = (w_new[x] > 0.0f) & (sdf[x] >= -volume.truncation_m) &
                 (depth[x] - z[x] >= -volume.truncation_m) & (frozen[x] == 0);
      any_fused |= fused[x];
      const float measured = max_of(min_of(sdf[x] / volume.truncation_m, 1.0f), -1.0f);
      const auto w_old = static_cast<float>(old_weight[x]);
      const float share = w_new[x] / max_of(w_old + w_new[x], 1.0f);
      const float mean = static_cast<float>(distance[x]) +
                         share * (measured * Voxel::kDistanceUnits - static_cast<float>(distance[x]));
      const auto mean_units = static_cast<int32_t>(floorf(mean + 0.5f));
      const auto total_units = static_cast<int32_t>(min_of(w_old + w_new[x], max_weight_units));
      distance[x] = fused[x] ? mean_units : distance[x];
      new_weight[x] = fused[x] ? total_units : old_weight[x];
      near_surface |= (new_weight[x] > 0) & (distance[x] < kNearSurface);
    }
    row_flags[i] = static_cast<uint8_t>((near_surface ? kRowSurface : 0) | (any_fused ? kRowFused : 0));
    if (!any_fused) return;
    for (int x = 0; x < kN; ++x) {
      const int32_t flag = frozen[x] ? Voxel::kFrozen : 0;
      volume.voxels[first + x] = {static_cast<int16_t>(distance[x]),
                                  static_cast<uint16_t>(new_weight[x] | flag)};
    }
    for (int x = 0; x < kN; ++x) {
      if (fused[x] && fabsf(sdf[x]) < kColourVoxels * volume.voxel_size_m)
        fuse_colour(pixels[pixel_index[x]].rgba, w_new[x], &volume.colours[first + x]);
    }
  }

 private:
  // Vertices lie within one voxel of those that give them colour; the rest is for noise.
  static constexpr float kColourVoxels = 2.0f;
  static constexpr int kNearSurface = 32000;  // distance units: anything but free space seen empty

  KT_HOST_DEVICE void fuse_colour(uint32_t rgba, float w_new, ColourVoxel* colour) const {
    if (rgba == 0) return;
    const auto w_old = static_cast<float>(colour->weight_units);
    const float share = w_new / (w_old + w_new);
    const auto blend = [share](uint16_t mean, uint32_t level) {
      const auto old_value = static_cast<float>(mean);
      return static_cast<uint16_t>(old_value + share * (static_cast<float>(level * 256) - old_value) + 0.5f);
    };
    *colour = {blend(colour->r, rgba & 255), blend(colour->g, rgba >> 8 & 255),
               blend(colour->b, rgba >> 16 & 255),
               static_cast<uint16_t>(min_of(w_old + w_new, max_weight_units))};
  }
};

/// State of a fused brick from its rows; one in which the frame measured nothing stays as it is.
struct SummariseBrick {
  VolumeView volume;
  const int32_t* slots;
  const uint8_t* row_flags;
  uint32_t frame_sequence;

  KT_HOST_DEVICE void operator()(int64_t i) const {
    constexpr int kRows = kBrickSide * kBrickSide;
    uint8_t flags = 0;
    for (int row = 0; row < kRows; ++row) flags |= row_flags[i * kRows + row];
    if (!(flags & kRowFused)) return;
    const int64_t slot = slots[i];
    volume.brick_states[slot] = flags & kRowSurface ? kBrickSurface : kBrickObserved;
    if (flags & kRowSurface) volume.brick_last_seen[slot] = frame_sequence;
  }
};

}  // namespace kt
