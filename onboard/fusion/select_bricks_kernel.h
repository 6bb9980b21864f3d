// Kernels that tell which bricks a frame changes.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "onboard/fusion/grid.h"
#include "onboard/preprocess/surface_kernel.h"
#include "shared/core/pinhole.h"
#include "shared/core/row_motion.h"

namespace kt {

/// Nearest and farthest fusable depth of a tile of pixels; nearest > farthest where there is none.
struct DepthRange {
  float nearest_m = 1e9f, farthest_m = 0.0f;
};
inline constexpr int kTileSide = 16;            // px
inline constexpr float kNearestVoxelM = 0.05f;  // nearer voxels are not fused

/// Of the pixels of one row in a tile; by tile across and row of the image, many for a GPU's threads to
/// share.
struct TileRowDepthRange {
  const FusionPixel* pixels;
  int32_t width;
  DepthRange* rows;  // out, ceil(width / kTileSide) per row

  KT_HOST_DEVICE void operator()(int tile_u, int v) const {
    DepthRange range;
    for (int u = tile_u * kTileSide; u < (tile_u + 1) * kTileSide && u < width; ++u) {
      const FusionPixel& pixel = pixels[int64_t{v} * width + u];
      if (pixel.weight_units() == 0) continue;
      range.nearest_m = min_of(range.nearest_m, pixel.depth_m);
      range.farthest_m = max_of(range.farthest_m, pixel.depth_m);
    }
    const int tiles_per_row = (width + kTileSide - 1) / kTileSide;
    rows[int64_t{v} * tiles_per_row + tile_u] = range;
  }
};

/// Of a tile, from its rows.
struct TileDepthRange {
  const DepthRange* rows;
  int32_t tiles_per_row, height;
  DepthRange* tiles;  // out

  KT_HOST_DEVICE void operator()(int tile_u, int tile_v) const {
    DepthRange range;
    for (int v = tile_v * kTileSide; v < (tile_v + 1) * kTileSide && v < height; ++v) {
      const DepthRange row = rows[int64_t{v} * tiles_per_row + tile_u];
      range.nearest_m = min_of(range.nearest_m, row.nearest_m);
      range.farthest_m = max_of(range.farthest_m, row.farthest_m);
    }
    tiles[int64_t{tile_v} * tiles_per_row + tile_u] = range;
  }
};

/// Flags the bricks that a frame changes: those that its truncation band may reach, and those that hold
/// surface where it sees through. Elements are bricks, block by block, so that those of a block that nothing
/// can reach cost little.
struct SelectBricks {
  VolumeView volume;
  PinholeParams camera;
  Rigid3f T_camera_volume;
  const DepthRange* tiles;
  uint8_t* selected;  // out, by slot
  RowMotion shutter{};

  static constexpr int kBlockBricks = kBlockSide * kBlockSide * kBlockSide;

  template <int kLanes>
  KT_HOST_DEVICE void run(int64_t i) const {
    static_assert(kBlockBricks % kLanes == 0);
    const int64_t block = i / kBlockBricks;
    const int first = static_cast<int>(i % kBlockBricks);
    const int blocks = volume.bricks / kBlockSide;
    const Vec3i low{static_cast<int32_t>(block % blocks) * kBlockSide,
                    static_cast<int32_t>(block / blocks % blocks) * kBlockSide,
                    static_cast<int32_t>(block / blocks / blocks) * kBlockSide};
    const Sphere around = sphere(low, kBlockSide);
    const bool any = can_be_seen(around) && changes(around, holds_surface(low));
    // Blocks are aligned in the ring: four bricks along x are neighbours there too.
    constexpr int kAlongX = kLanes < kBlockSide ? kLanes : kBlockSide;
    for (int k = first; k < first + kLanes; k += kAlongX) {
      const Vec3i brick = brick_of(low, k);
      const int64_t slot = volume.slot(brick);
      for (int x = 0; x < kAlongX; ++x) {
        const bool is_surface = volume.brick_states[slot + x] == kBrickSurface;
        selected[slot + x] = any && changes(sphere(brick + Vec3i{x, 0, 0}, 1), is_surface) ? 1 : 0;
      }
    }
  }

 private:
  struct Sphere {
    Vec3f p;  // centre in the camera frame (m)
    float radius;
  };

  // Brick k of the block whose lowest is `low`.
  KT_HOST_DEVICE static Vec3i brick_of(Vec3i low, int k) {
    return low + Vec3i{k % kBlockSide, k / kBlockSide % kBlockSide, k / kBlockSide / kBlockSide};
  }

  // Whether a brick of the block whose lowest is `low` does.
  KT_HOST_DEVICE bool holds_surface(Vec3i low) const {
    bool holds = false;
    for (int row = 0; row < kBlockBricks; row += kBlockSide) {
      const uint8_t* states = volume.brick_states + volume.slot(brick_of(low, row));
      for (int x = 0; x < kBlockSide; ++x) holds |= states[x] == kBrickSurface;
    }
    return holds;
  }

  // Around the voxel centres of the cube of `side` bricks whose lowest is b.
  KT_HOST_DEVICE Sphere sphere(Vec3i b, int side) const {
    const float half = 0.5f * static_cast<float>(side * kBrickSide - 1);
    const Vec3f centre{static_cast<float>(b.x * kBrickSide) + half,
                       static_cast<float>(b.y * kBrickSide) + half,
                       static_cast<float>(b.z * kBrickSide) + half};
    const Vec3f p = T_camera_volume * (centre * volume.voxel_size_m);
    const float radius = 1.7320508f * half * volume.voxel_size_m;
    // At the first row and the last; of the farthest point of the sphere.
    const float moved = (norm(shutter.per_row(p)) + norm(shutter.omega) * radius) * shutter.middle_row;
    return {p, radius + moved};
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
    if (s.p.z + s.radius < kNearestVoxelM) return false;
    // The pixels of its points lie in this box: |x / z - x_0 / z_0| is at most r sqrt(1 + (x_0 / z_0)^2) /
    // (z_0 - r).
    const float scale = 1.0f / max_of(s.p.z, kNearestVoxelM),
                per_z = s.radius / max_of(s.p.z - s.radius, kNearestVoxelM);
    const float du = s.p.x * scale * camera.fx, dv = s.p.y * scale * camera.fy;
    const float reach_u = per_z * sqrtf(camera.fx * camera.fx + du * du) + 0.5f,
                reach_v = per_z * sqrtf(camera.fy * camera.fy + dv * dv) + 0.5f;
    const float u = camera.cx + du + 0.5f, v = camera.cy + dv + 0.5f;
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

}  // namespace kt
