// Kernels that predict the surface the volume shows to a camera.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "onboard/fusion/brick_distance_kernel.h"
#include "onboard/fusion/volume_sampler.h"
#include "shared/core/pinhole.h"

namespace kt {

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

  /// Depth at which the ray leaves the cube of bricks that are fewer than `reach` bricks from `brick`, reach
  /// >= 1.
  KT_HOST_DEVICE float exit_depth(Vec3i brick, int reach) const {
    return min_of(
        min_of(exit_axis(brick.x, reach, start.x, inverse.x), exit_axis(brick.y, reach, start.y, inverse.y)),
        exit_axis(brick.z, reach, start.z, inverse.z));
  }
  /// The same along one axis.
  KT_HOST_DEVICE static float exit_axis(int brick, int reach, float s, float inv) {
    const int border = inv > 0.0f ? brick + reach : brick - reach + 1;
    return (static_cast<float>(border * kBrickSide) - 0.5f - s) * inv;
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
};

inline constexpr int kRayTileSide = 8;  // px
inline constexpr int kTilePixels = kRayTileSide * kRayTileSide;
inline constexpr float kRayNudgeM = 1e-4f;  // past a cell border, so that rounding cannot stop a ray on it

/// The stretch of depth in which pixels of a tile can meet surface.
struct RayStretch {
  float start_m = 0, end_m = 0;
};

/// Finds the stretch from the bricks near the tile's middle ray: at the same depth, a ray of the tile is no
/// farther from it than half the tile's diagonal, so what it meets lies within as many bricks as that
/// distance takes.
struct RaycastTile {
  VolumeView volume;
  const uint8_t* brick_distances;  // by slot
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
    // How far the tile's rays stray from the middle one per metre of depth.
    const float spread = half * sqrtf(1.0f / (camera.fx * camera.fx) + 1.0f / (camera.fy * camera.fy));
    const float brick_m = kBrickSide * volume.voxel_size_m;
    constexpr float kLongestLeap = 1.7320508f * (2 * kFarthestBrick - 3);  // bricks: across the largest cube
    RayStretch stretch{max_depth_m, 0.0f};
    for (float t = ray.enter_m; t < ray.leave_m;) {
      const Vec3i v = VolumeRay::nearest_voxel(ray.at(t));
      if (!volume.contains(v)) break;
      const Vec3i brick = VolumeView::brick_of(v);
      const int distance = brick_distances[volume.slot(brick)];
      const float farthest_m = t + kLongestLeap * brick_m;
      const int near = 1 + static_cast<int>(min_of(spread * farthest_m / brick_m, 1e3f));
      const bool can_meet = distance <= near;
      const float exit = max_of(ray.exit_depth(brick, can_meet ? 1 : distance - near), t) + kRayNudgeM;
      if (can_meet) {
        stretch.start_m = min_of(stretch.start_m, t);
        stretch.end_m = exit;
      }
      t = exit;
    }
    // Other rays may enter the volume where the middle one does not, and leave it much later.
    if (ray.enter_m > min_depth_m) stretch.start_m = min_depth_m;
    if (ray.leave_m < max_depth_m) stretch.end_m = max_depth_m;
    stretches[int64_t{tile_v} * ((camera.width + kRayTileSide - 1) / kRayTileSide) + tile_u] = {
        stretch.start_m - spread * stretch.start_m, stretch.end_m + spread * stretch.end_m};
  }
};

/// Surface prediction (Newcombe et al. 2011, sec. 3.4): marches the rays of kLanes neighbouring pixels to
/// their first zero crossing from positive to negative. Rays step over bricks without surface, and by the
/// distance field elsewhere. They march in step, so that a CPU computes them as SIMD and overlaps their
/// look-ups. Elements are pixels tile by tile, so that neighbours in time read the same bricks.
struct RaycastPixel {
  VolumeSampler sampler;
  const uint8_t* brick_distances;  // by slot
  PinholeParams camera;
  Rigid3f T_volume_camera;
  float min_depth_m, max_depth_m;
  const RayStretch* stretches;
  Vec4f* points;   // out: hit in the camera frame (m), w = 1; all 0 where there is none
  Vec4f* normals;  // out: unit normal in the camera frame, w = 1

  /// Elements to run for an image.
  static int64_t element_count(const PinholeParams& camera) {
    const auto tiles = [](int pixels) { return int64_t{(pixels + kRayTileSide - 1) / kRayTileSide}; };
    return tiles(camera.width) * tiles(camera.height) * kTilePixels;
  }

  template <int kLanes>
  KT_HOST_DEVICE void run(int64_t element) const {
    static_assert(kTilePixels % kLanes == 0);
    const int tiles_per_row = (camera.width + kRayTileSide - 1) / kRayTileSide;
    const int tile = static_cast<int>(element / kTilePixels), pixel = static_cast<int>(element % kTilePixels);
    const int u0 = tile % tiles_per_row * kRayTileSide, v0 = tile / tiles_per_row * kRayTileSide;
    Rays<kLanes> rays;
    rays.start = T_volume_camera.t * (1.0f / sampler.volume.voxel_size_m);
    const float nearest_m = max_of(stretches[tile].start_m, min_depth_m),
                farthest_m = min_of(stretches[tile].end_m, max_depth_m);
    for (int l = 0; l < kLanes; ++l) {
      rays.set(l, VolumeRay(sampler.volume, T_volume_camera,
                            camera.unproject(static_cast<float>(u0 + column(pixel + l)),
                                             static_cast<float>(v0 + row(pixel + l)), 1.0f),
                            nearest_m, farthest_m));
    }
    march(&rays);
    Surface<kLanes> surface;
    finish(rays, u0, v0, pixel, &surface);
    for (int l = 0; l < kLanes; ++l) {
      const int u = u0 + column(pixel + l), v = v0 + row(pixel + l);
      if (u >= camera.width || v >= camera.height) continue;
      const int64_t i = int64_t{v} * camera.width + u;
      points[i] = {surface.p.x[l], surface.p.y[l], surface.p.z[l], surface.found[l]};
      normals[i] = {surface.n.x[l], surface.n.y[l], surface.n.z[l], surface.found[l]};
    }
  }

 private:
  // Where a pixel stands in its tile.
  KT_HOST_DEVICE static int column(int pixel) { return pixel % kRayTileSide; }
  KT_HOST_DEVICE static int row(int pixel) { return pixel / kRayTileSide; }

  // Points and normals in the camera frame; all 0 where there is none.
  template <int kLanes>
  struct Surface {
    Vec3fs<kLanes> p, n;
    float found[kLanes];
  };

  // The rays and where each has got to, as arrays over the lanes.
  template <int kLanes>
  struct Rays {
    Vec3f start;  // voxel units
    float dx[kLanes], dy[kLanes], dz[kLanes], ix[kLanes], iy[kLanes], iz[kLanes];
    float t[kLanes], leave[kLanes];  // depth (m)
    float voxel_step[kLanes];        // metres of depth per voxel along the ray
    int32_t active[kLanes], hit[kLanes];

    KT_HOST_DEVICE void set(int l, const VolumeRay& ray) {
      dx[l] = ray.direction.x, dy[l] = ray.direction.y, dz[l] = ray.direction.z;
      ix[l] = ray.inverse.x, iy[l] = ray.inverse.y, iz[l] = ray.inverse.z;
      voxel_step[l] = 1.0f / norm(ray.direction);
      leave[l] = ray.leave_m;
      active[l] = ray.enter_m < ray.leave_m;
      t[l] = active[l] ? ray.enter_m : 0.0f;
      hit[l] = 0;
    }
    KT_HOST_DEVICE Vec3f direction(int l) const { return {dx[l], dy[l], dz[l]}; }
  };

  // Takes each ray to the sign change between two voxels, by linear interpolation.
  template <int kLanes>
  KT_HOST_DEVICE void march(Rays<kLanes>* rays) const {
    const VolumeView& volume = sampler.volume;
    const Vec3f s = rays->start;
    const auto voxels_per_axis = static_cast<uint32_t>(volume.voxels_per_axis());
    const float tsdf_voxels = 0.8f * volume.truncation_m / volume.voxel_size_m;
    float last_t[kLanes], last_tsdf[kLanes];  // last positive sample, 0 = none
    for (int l = 0; l < kLanes; ++l) last_t[l] = last_tsdf[l] = 0.0f;
    while (true) {
      int32_t bx[kLanes], by[kLanes], bz[kLanes], slot[kLanes], offset[kLanes];
      int32_t any = 0;
      for (int l = 0; l < kLanes; ++l) {
        const float t = rays->t[l];
        const int32_t x = static_cast<int32_t>(s.x + rays->dx[l] * t + 0.5f),
                      y = static_cast<int32_t>(s.y + rays->dy[l] * t + 0.5f),
                      z = static_cast<int32_t>(s.z + rays->dz[l] * t + 0.5f);
        const int32_t inside = (static_cast<uint32_t>(x) < voxels_per_axis) &
                               (static_cast<uint32_t>(y) < voxels_per_axis) &
                               (static_cast<uint32_t>(z) < voxels_per_axis);
        rays->active[l] &= (t < rays->leave[l]) & inside;
        any |= rays->active[l];
        bx[l] = x >> kLog2BrickSide, by[l] = y >> kLog2BrickSide, bz[l] = z >> kLog2BrickSide;
        const int32_t ring = (volume.wrap(bz[l] + volume.ring_origin.z) * volume.bricks +
                              volume.wrap(by[l] + volume.ring_origin.y)) *
                                 volume.bricks +
                             volume.wrap(bx[l] + volume.ring_origin.x);
        slot[l] = rays->active[l] ? ring : 0;
        offset[l] = rays->active[l] ? ((z & 7) * kBrickSide + (y & 7)) * kBrickSide + (x & 7) : 0;
      }
      if (!any) return;
      int32_t reach[kLanes], distance[kLanes], weight[kLanes];
      for (int l = 0; l < kLanes; ++l) {
        reach[l] = brick_distances[slot[l]];
        // A brick without surface is not read: its memory may never have been touched.
        const Voxel voxel = volume.voxels[reach[l] == 0 ? int64_t{slot[l]} * kBrickVoxels + offset[l] : 0];
        distance[l] = voxel.distance();
        weight[l] = voxel.weight_units();
      }
      for (int l = 0; l < kLanes; ++l) {
        const float t = rays->t[l], step = rays->voxel_step[l], before_t = last_t[l], before = last_tsdf[l];
        const int32_t active = rays->active[l], in_surface = reach[l] == 0;
        const float tsdf = static_cast<float>(distance[l]) / Voxel::kDistanceUnits;
        const int32_t observed = in_surface & (weight[l] > 0), in_front = observed & (tsdf >= 0.0f),
                      crossed = active & observed & (tsdf < 0.0f) & (before > 0.0f);
        const float crossing = before_t + (t - before_t) * before / (before - tsdf);
        // Behind a surface, or where nothing was observed, voxel by voxel.
        const float field_step = max_of(0.75f * step, tsdf * (tsdf_voxels * step));
        const float inside_brick = t + (in_front ? field_step : step);
        const float exit = min_of(min_of(VolumeRay::exit_axis(bx[l], reach[l], s.x, rays->ix[l]),
                                         VolumeRay::exit_axis(by[l], reach[l], s.y, rays->iy[l])),
                                  VolumeRay::exit_axis(bz[l], reach[l], s.z, rays->iz[l]));
        const float past_bricks = max_of(exit, t) + kRayNudgeM;
        const float next = in_surface ? inside_brick : past_bricks;
        const float kept = observed ? before : 0.0f;
        last_t[l] = in_front ? t : before_t;
        last_tsdf[l] = in_front ? max_of(tsdf, 1e-6f) : kept;
        const float moved = active ? next : t;
        rays->t[l] = crossed ? crossing : moved;
        rays->hit[l] |= crossed;
        rays->active[l] = active & (crossed ^ 1);
      }
    }
  }

  // Two Newton steps along the ray on the trilinear field, then point and normal; nothing where the field is
  // not observed there, or the surface faces away.
  template <int kLanes>
  KT_HOST_DEVICE void finish(const Rays<kLanes>& rays, int u0, int v0, int pixel,
                             Surface<kLanes>* surface) const {
    const Vec3f start = rays.start;
    const float truncation_m = sampler.volume.truncation_m;
    float depth[kLanes];
    int32_t found[kLanes];
    for (int l = 0; l < kLanes; ++l) depth[l] = rays.t[l];
    for (int l = 0; l < kLanes; ++l) found[l] = rays.hit[l];
    VolumeSampler::Samples<kLanes> samples;
    for (int step = 0; step < 2; ++step) {
      Vec3fs<kLanes> g;
      for (int l = 0; l < kLanes; ++l) g.set(l, start + rays.direction(l) * depth[l]);
      sampler.sample(g, found, &samples);
      for (int l = 0; l < kLanes; ++l) {
        const float slope = dot(samples.gradient.at(l), rays.direction(l));  // per metre of depth
        const int32_t falls = samples.observed[l] & (slope < -1e-3f);
        const float correction = samples.tsdf[l] / (falls ? slope : -1.0f);
        found[l] = falls & (fabsf(correction) <= truncation_m);
        depth[l] -= found[l] ? correction : 0.0f;
      }
    }
    const float* R = T_volume_camera.R.m;  // its transpose turns the gradient into the camera frame
    for (int l = 0; l < kLanes; ++l) {
      const Vec3f gradient = samples.gradient.at(l);
      const float length = norm(gradient), inverse_length = 1.0f / max_of(length, 1e-6f);
      const Vec3f n = Vec3f{R[0] * gradient.x + R[3] * gradient.y + R[6] * gradient.z,
                            R[1] * gradient.x + R[4] * gradient.y + R[7] * gradient.z,
                            R[2] * gradient.x + R[5] * gradient.y + R[8] * gradient.z} *
                      inverse_length;
      const Vec3f p = camera.unproject(static_cast<float>(u0 + column(pixel + l)),
                                       static_cast<float>(v0 + row(pixel + l)), 1.0f) *
                      depth[l];
      const int32_t shown = found[l] & (length > 1e-6f) & (dot(n, p) < 0.0f);
      surface->p.set(l, {shown ? p.x : 0.0f, shown ? p.y : 0.0f, shown ? p.z : 0.0f});
      surface->n.set(l, {shown ? n.x : 0.0f, shown ? n.y : 0.0f, shown ? n.z : 0.0f});
      surface->found[l] = shown ? 1.0f : 0.0f;
    }
  }
};

}  // namespace kt
