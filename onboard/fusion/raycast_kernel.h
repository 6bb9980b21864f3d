// Kernel that predicts the surface the volume shows to one pixel.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "onboard/fusion/grid.h"
#include "shared/core/pinhole.h"

namespace kt {

/// Trilinear samples of the volume; positions in local voxel units.
struct VolumeSampler {
  VolumeView volume;

  /// TSDF (and its gradient per voxel, where asked) inside the cell of g; false where a corner is unobserved
  /// or outside.
  KT_HOST_DEVICE bool sample(Vec3f g, float* tsdf, Vec3f* gradient = nullptr) const {
    const float limit = static_cast<float>(volume.voxels_per_axis() - 1);
    if (!(g.x >= 0.0f && g.y >= 0.0f && g.z >= 0.0f && g.x < limit && g.y < limit && g.z < limit))
      return false;
    const Vec3i v{static_cast<int32_t>(g.x), static_cast<int32_t>(g.y), static_cast<int32_t>(g.z)};
    const float x = g.x - static_cast<float>(v.x), y = g.y - static_cast<float>(v.y),
                z = g.z - static_cast<float>(v.z);
    float f[8];
    int observed = 1;
    if ((v.x & 7) < 7 && (v.y & 7) < 7 && (v.z & 7) < 7) {  // the usual case: one brick
      const Voxel* base = volume.voxels + volume.index(v);
      for (int k = 0; k < 8; ++k) {
        const Voxel voxel = base[(k & 1) + (k >> 1 & 1) * kBrickSide + (k >> 2) * kBrickSide * kBrickSide];
        f[k] = voxel.tsdf();
        observed &= voxel.weight_units() > 0;
      }
    } else {
      for (int k = 0; k < 8; ++k) {
        const Voxel voxel = volume.voxels[volume.index({v.x + (k & 1), v.y + (k >> 1 & 1), v.z + (k >> 2)})];
        f[k] = voxel.tsdf();
        observed &= voxel.weight_units() > 0;
      }
    }
    if (!observed) return false;
    const float f00 = f[0] + x * (f[1] - f[0]), f10 = f[2] + x * (f[3] - f[2]);
    const float f01 = f[4] + x * (f[5] - f[4]), f11 = f[6] + x * (f[7] - f[6]);
    const float f0 = f00 + y * (f10 - f00), f1 = f01 + y * (f11 - f01);
    *tsdf = f0 + z * (f1 - f0);
    if (gradient) {
      const float dx0 = (f[1] - f[0]) + y * ((f[3] - f[2]) - (f[1] - f[0]));
      const float dx1 = (f[5] - f[4]) + y * ((f[7] - f[6]) - (f[5] - f[4]));
      *gradient = {dx0 + z * (dx1 - dx0), (f10 - f00) + z * ((f11 - f01) - (f10 - f00)), f1 - f0};
    }
    return true;
  }
};

/// Whether a brick or one of its 26 neighbours holds surface; by block, whose 64 bricks it writes. Rays
/// through a tile of pixels stay within one brick of the tile's middle ray, so they miss nothing while that
/// ray meets no such brick.
struct DilateBlock {
  VolumeView volume;
  uint8_t* near_surface;  // out, by brick slot

  KT_HOST_DEVICE void operator()(int64_t block_slot) const {
    const int blocks = volume.bricks / kBlockSide;
    const int64_t ring_x = block_slot % blocks * kBlockSide,
                  ring_y = block_slot / blocks % blocks * kBlockSide,
                  ring_z = block_slot / blocks / blocks * kBlockSide;
    const Vec3i low = volume.brick((ring_z * volume.bricks + ring_y) * volume.bricks + ring_x);
    const bool any = any_neighbour(
        low, kBlockSide, [this](Vec3i b) { return volume.block_states[volume.block_slot(b)] != 0; });
    for (int k = 0; k < kBlockSide * kBlockSide * kBlockSide; ++k) {
      const Vec3i b = low + Vec3i{k % kBlockSide, k / kBlockSide % kBlockSide, k / kBlockSide / kBlockSide};
      near_surface[volume.slot(b)] = any && any_neighbour(b, 1, [this](Vec3i n) {
                                       return volume.brick_states[volume.slot(n)] == kBrickSurface;
                                     });
    }
  }

  /// Whether `test` holds for b or one of those `step` bricks beside it, inside the volume.
  template <typename Test>
  KT_HOST_DEVICE bool any_neighbour(Vec3i b, int step, const Test& test) const {
    for (int k = 0; k < 27; ++k) {
      const Vec3i n{b.x + (k % 3 - 1) * step, b.y + (k / 3 % 3 - 1) * step, b.z + (k / 9 - 1) * step};
      const auto bricks = static_cast<uint32_t>(volume.bricks);
      if (static_cast<uint32_t>(n.x) < bricks && static_cast<uint32_t>(n.y) < bricks &&
          static_cast<uint32_t>(n.z) < bricks && test(n))
        return true;
    }
    return false;
  }
};

/// A ray through the volume, parametrised by the camera's depth (m).
struct VolumeRay {
  Vec3f start, direction,
      inverse;             // voxel units; voxel units per metre of depth; metres of depth per voxel unit
  float enter_m, leave_m;  // where it is inside the volume

  KT_HOST_DEVICE VolumeRay(const VolumeView& volume, const Rigid3f& T_volume_camera, Vec3f ray_camera,
                           float min_depth_m, float max_depth_m) {
    const float inverse_voxel = 1.0f / volume.voxel_size_m;
    start = T_volume_camera.t * inverse_voxel;
    direction = (T_volume_camera.R * ray_camera) * inverse_voxel;
    inverse = {safe_inverse(direction.x), safe_inverse(direction.y), safe_inverse(direction.z)};
    const float high = static_cast<float>(volume.voxels_per_axis() - 1);
    enter_m = min_depth_m;
    leave_m = max_depth_m;
    clip(start.x, inverse.x, high);
    clip(start.y, inverse.y, high);
    clip(start.z, inverse.z, high);
  }

  KT_HOST_DEVICE Vec3f at(float depth_m) const { return start + direction * depth_m; }

  /// Nearest voxel of a point; it lies inside for depths in [enter_m, leave_m], but for rounding.
  KT_HOST_DEVICE static Vec3i nearest_voxel(Vec3f g) {
    return {static_cast<int32_t>(g.x + 0.5f), static_cast<int32_t>(g.y + 0.5f),
            static_cast<int32_t>(g.z + 0.5f)};
  }

  /// Depth at which the ray leaves the aligned cell of 2^log2_side voxels that holds voxel `v`.
  KT_HOST_DEVICE float exit_depth(Vec3i v, int log2_side) const {
    return min_of(
        min_of(exit_axis(v.x, start.x, inverse.x, log2_side), exit_axis(v.y, start.y, inverse.y, log2_side)),
        exit_axis(v.z, start.z, inverse.z, log2_side));
  }

 private:
  KT_HOST_DEVICE static float safe_inverse(float x) {
    return 1.0f / (fabsf(x) > 1e-6f ? x : (x < 0.0f ? -1e-6f : 1e-6f));
  }
  KT_HOST_DEVICE void clip(float s, float inv, float high) {
    const float a = (0.0f - s) * inv, b = (high - s) * inv;
    enter_m = max_of(enter_m, min_of(a, b));
    leave_m = min_of(leave_m, max_of(a, b));
  }
  KT_HOST_DEVICE static float exit_axis(int coordinate, float s, float inv, int log2_side) {
    const int cell = (coordinate >> log2_side) + (inv > 0.0f ? 1 : 0);
    return (static_cast<float>(cell << log2_side) - 0.5f - s) * inv;
  }
};

inline constexpr int kRayTileSide = 8;      // px
inline constexpr float kRayNudgeM = 1e-4f;  // past a cell border, so that rounding cannot stop a ray on it

/// The stretch of depth in which pixels of a tile can meet surface, from the bricks on the tile's middle ray.
struct RayStretch {
  float start_m = 0, end_m = 0;
};

struct RaycastTile {
  VolumeView volume;
  const uint8_t* near_surface;
  PinholeParams camera;
  Rigid3f T_volume_camera;
  float min_depth_m, max_depth_m;
  RayStretch* stretches;  // out, ceil(width / kRayTileSide) per row

  KT_HOST_DEVICE void operator()(int tile_u, int tile_v) const {
    const float half = 0.5f * (kRayTileSide - 1);
    const VolumeRay ray(volume, T_volume_camera,
                        camera.unproject(static_cast<float>(tile_u * kRayTileSide) + half,
                                         static_cast<float>(tile_v * kRayTileSide) + half, 1.0f),
                        min_depth_m, max_depth_m);
    RayStretch stretch{max_depth_m, 0.0f};
    for (float t = ray.enter_m; t < ray.leave_m;) {
      const Vec3i v = VolumeRay::nearest_voxel(ray.at(t));
      if (!volume.contains(v)) break;
      const float exit = max_of(ray.exit_depth(v, kLog2BrickSide), t) + kRayNudgeM;
      if (near_surface[volume.slot(VolumeView::brick_of(v))]) {
        stretch.start_m = min_of(stretch.start_m, t);
        stretch.end_m = exit;
      }
      t = exit;
    }
    // The rays at the rim of the tile may enter and leave a little sooner or later.
    const float brick_m = kBrickSide * volume.voxel_size_m;
    stretches[int64_t{tile_v} * ((camera.width + kRayTileSide - 1) / kRayTileSide) + tile_u] = {
        stretch.start_m - brick_m, stretch.end_m + brick_m};
  }
};

/// Surface prediction (Newcombe et al. 2011, sec. 3.4): marches the ray of a pixel to the first zero crossing
/// from positive to negative. Rays step over bricks without surface, and by the distance field elsewhere.
/// Elements go tile by tile, so that neighbours in time read the same bricks.
struct RaycastPixel {
  VolumeSampler sampler;
  PinholeParams camera;
  Rigid3f T_volume_camera;
  float min_depth_m, max_depth_m;
  const RayStretch* stretches;
  Vec4f* points;   // out: hit in the camera frame (m), w = 1; all 0 where there is none
  Vec4f* normals;  // out: unit normal in the camera frame, w = 1

  /// Elements to run for an image.
  static int64_t element_count(const PinholeParams& camera) {
    const auto tiles = [](int pixels) { return int64_t{(pixels + kRayTileSide - 1) / kRayTileSide}; };
    return tiles(camera.width) * tiles(camera.height) * kRayTileSide * kRayTileSide;
  }

  KT_HOST_DEVICE void operator()(int64_t element) const {
    constexpr int kTilePixels = kRayTileSide * kRayTileSide;
    const int tiles_per_row = (camera.width + kRayTileSide - 1) / kRayTileSide;
    const int tile = static_cast<int>(element / kTilePixels), pixel = static_cast<int>(element % kTilePixels);
    const int u = tile % tiles_per_row * kRayTileSide + pixel % kRayTileSide,
              v = tile / tiles_per_row * kRayTileSide + pixel / kRayTileSide;
    if (u >= camera.width || v >= camera.height) return;
    Vec4f point, normal;
    const Vec3f ray_camera = camera.unproject(static_cast<float>(u), static_cast<float>(v), 1.0f);
    const VolumeRay ray(sampler.volume, T_volume_camera, ray_camera,
                        max_of(stretches[tile].start_m, min_depth_m),
                        min_of(stretches[tile].end_m, max_depth_m));
    float depth;
    Vec3f gradient;
    if (march(ray, &depth) && polish(ray, &depth, &gradient)) {
      const float length = norm(gradient);
      const float* R = T_volume_camera.R.m;  // its transpose turns the gradient into the camera frame
      const Vec3f n = Vec3f{R[0] * gradient.x + R[3] * gradient.y + R[6] * gradient.z,
                            R[1] * gradient.x + R[4] * gradient.y + R[7] * gradient.z,
                            R[2] * gradient.x + R[5] * gradient.y + R[8] * gradient.z} *
                      (1.0f / length);
      const Vec3f p = ray_camera * depth;
      if (length > 1e-6f && dot(n, p) < 0.0f) {  // else a back face
        point = {p.x, p.y, p.z, 1.0f};
        normal = {n.x, n.y, n.z, 1.0f};
      }
    }
    const int64_t i = int64_t{v} * camera.width + u;
    points[i] = point;
    normals[i] = normal;
  }

  // Depth of the sign change between voxels, by linear interpolation.
  KT_HOST_DEVICE bool march(const VolumeRay& ray, float* depth) const {
    const VolumeView& volume = sampler.volume;
    const float voxel_step = 1.0f / norm(ray.direction);  // metres of depth per voxel along the ray
    const float tsdf_step = 0.8f * volume.truncation_m / volume.voxel_size_m * voxel_step;
    float last_t = 0.0f, last_tsdf = 0.0f;  // last positive sample, 0 = none
    float t = ray.enter_m;
    while (t < ray.leave_m) {
      const Vec3i v = VolumeRay::nearest_voxel(ray.at(t));
      if (!volume.contains(v)) return false;
      const int64_t slot = volume.slot(VolumeView::brick_of(v));
      if (volume.brick_states[slot] != kBrickSurface) {
        t = max_of(ray.exit_depth(v, kLog2BrickSide), t) + kRayNudgeM;
        last_tsdf = 0.0f;
        continue;
      }
      const Voxel voxel =
          volume.voxels[slot * kBrickVoxels + ((v.z & 7) * kBrickSide + (v.y & 7)) * kBrickSide + (v.x & 7)];
      const float tsdf = voxel.tsdf();
      if (voxel.weight_units() == 0) {
        last_tsdf = 0.0f;
        t += voxel_step;
      } else if (tsdf >= 0.0f) {
        last_tsdf = max_of(tsdf, 1e-6f);
        last_t = t;
        t += max_of(0.75f * voxel_step, tsdf * tsdf_step);
      } else if (last_tsdf > 0.0f) {
        *depth = last_t + (t - last_t) * last_tsdf / (last_tsdf - tsdf);
        return true;
      } else {
        t += voxel_step;  // inside or behind something: go on to its far side
      }
    }
    return false;
  }

  // Two Newton steps along the ray on the trilinear field; false where it is not observed there.
  KT_HOST_DEVICE bool polish(const VolumeRay& ray, float* depth, Vec3f* gradient) const {
    const float reach = sampler.volume.truncation_m;
    for (int step = 0; step < 2; ++step) {
      float tsdf;
      if (!sampler.sample(ray.at(*depth), &tsdf, gradient)) return false;
      const float slope = dot(*gradient, ray.direction);  // per metre of depth
      if (!(slope < -1e-3f)) return false;
      const float correction = tsdf / slope;
      if (fabsf(correction) > reach) return false;
      *depth -= correction;
    }
    return true;
  }
};

}  // namespace kt
