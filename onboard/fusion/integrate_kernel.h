// Kernels that fuse one frame into the volume.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "onboard/fusion/grid.h"
#include "onboard/fusion/select_bricks_kernel.h"
#include "onboard/preprocess/surface_kernel.h"
#include "shared/core/pinhole.h"
#include "shared/core/row_motion.h"

namespace kt {

/// Fuses a frame into kLanes neighbouring columns of 8 voxels along z: weighted running average of the
/// truncated signed distance to the tangent plane of the measured surface (Curless and Levoy 1996; Newcombe
/// et al. 2011, eq. 6 to 13) and of the colour. Behind the measurement it reaches one truncation distance
/// along the ray: farther off, the tangent plane says nothing about the surface.
///   sdf = (depth - z) * distance_scale;  F' = (W F + w min(sdf / mu, 1)) / (W + w);  W' = min(W + w, W_max)
/// Elements are the columns of the selected bricks. The pixels of all voxels are looked up first, so that a
/// CPU waits for many at a time and a row of voxels in which the frame measured nothing is never read.
struct FuseColumns {
  VolumeView volume;
  PinholeParams camera;
  Rigid3f T_camera_volume;
  const int32_t* slots;  // selected bricks
  const FusionPixel* pixels;
  const uint32_t* colours;  // rgba by pixel, a = trust in it (255: full), or null
  float max_weight_units;
  uint8_t* column_fused;  // out, by element: whether the frame measured a voxel of the column
  RowMotion shutter{};

  template <int kLanes>
  KT_HOST_DEVICE void run(int64_t i) const {
    static_assert(kBrickSide % kLanes == 0);
    const int64_t slot = slots[i / kBrickColumns];
    const int column = static_cast<int>(i % kBrickColumns);
    Measured<kLanes> measured;
    look_up(slot, column, &measured);
    uint8_t* masks = volume.surface_masks + slot * kBrickColumns + column;
    int32_t mask[kLanes], any[kLanes];
    for (int l = 0; l < kLanes; ++l) mask[l] = masks[l];
    for (int l = 0; l < kLanes; ++l) any[l] = 0;
    for (int z = 0; z < kBrickSide; ++z) {
      int32_t row = 0;
      for (int l = 0; l < kLanes; ++l) row |= measured.weight[z * kLanes + l];
      if (row) fuse_row(slot * kBrickVoxels + z * kBrickColumns + column, z, measured, mask, any);
    }
    for (int l = 0; l < kLanes; ++l) masks[l] = static_cast<uint8_t>(mask[l]);
    for (int l = 0; l < kLanes; ++l) column_fused[i + l] = static_cast<uint8_t>(any[l]);
  }

 private:
  // Vertices lie within one voxel of those that give them colour; the rest is for noise.
  static constexpr float kColourVoxels = 2.0f;
  static_assert(FusionPixel::kWeightUnits == Voxel::kWeightUnits, "weights are added as they are");
  static constexpr int kNearSurface = 32000;  // distance units: anything but free space seen empty

  template <int kLanes>
  static constexpr int kCount = kBrickSide* kLanes;

  // What the frame says of kLanes columns of voxels, row by row.
  template <int kLanes>
  struct Measured {
    float sdf[kCount<kLanes>];       // m
    int32_t weight[kCount<kLanes>];  // units, 0 = nothing
    int32_t pixel[kCount<kLanes>];
  };

  template <int kLanes>
  KT_HOST_DEVICE void look_up(int64_t slot, int column, Measured<kLanes>* measured) const {
    const Vec3i b = volume.brick(slot);
    const int x0 = column % kBrickSide, y0 = column / kBrickSide;
    const Vec3f start = T_camera_volume * (Vec3f{static_cast<float>(b.x * kBrickSide),
                                                 static_cast<float>(b.y * kBrickSide + y0),
                                                 static_cast<float>(b.z * kBrickSide)} *
                                           volume.voxel_size_m);
    const float* R = T_camera_volume.R.m;
    const Vec3f along_x = Vec3f{R[0], R[3], R[6]} * volume.voxel_size_m,
                along_z = Vec3f{R[2], R[5], R[8]} * volume.voxel_size_m;
    const Vec3f motion = shutter.per_row(start), motion_x = cross(shutter.omega, along_x),
                motion_z = cross(shutter.omega, along_z);
    const float middle = shutter.middle_row - camera.cy;
    const auto width = static_cast<float>(camera.width), height = static_cast<float>(camera.height);
    float depth[kCount<kLanes>];
    int32_t seen[kCount<kLanes>], pixel[kCount<kLanes>];
    for (int z = 0; z < kBrickSide; ++z) {
      const Vec3f row_start = start + along_z * static_cast<float>(z),
                  row_motion = motion + motion_z * static_cast<float>(z);
      for (int l = 0; l < kLanes; ++l) {
        const auto offset = static_cast<float>(x0 + l);
        const Vec3f p = row_start + along_x * offset;  // at the middle row
        // From the middle row to the one that sees it, to first order.
        const float row = p.y / p.z * camera.fy - middle;
        const float later = max_of(min_of(row, shutter.middle_row), -shutter.middle_row);
        const Vec3f seen_at = p - (row_motion + motion_x * offset) * later;
        const float p_z = seen_at.z;
        const float inverse = 1.0f / p_z;
        const float u = seen_at.x * inverse * camera.fx + camera.cx + 0.5f;
        const float v = seen_at.y * inverse * camera.fy + camera.cy + 0.5f;
        const int32_t in_image =
            (p_z >= kNearestVoxelM) & (u >= 0.0f) & (v >= 0.0f) & (u < width) & (v < height);
        depth[z * kLanes + l] = p_z;
        seen[z * kLanes + l] = in_image;
        pixel[z * kLanes + l] = static_cast<int32_t>(in_image ? v : 0.0f) * camera.width +
                                static_cast<int32_t>(in_image ? u : 0.0f);
      }
    }
    float pixel_depth[kCount<kLanes>];
    uint32_t packed[kCount<kLanes>];
    for (int k = 0; k < kCount<kLanes>; ++k) {
      const FusionPixel looked_up = pixels[pixel[k]];
      pixel_depth[k] = looked_up.depth_m;
      packed[k] = looked_up.scale_and_weight;
      measured->pixel[k] = pixel[k];
    }
    const float behind = -volume.truncation_m;
    for (int k = 0; k < kCount<kLanes>; ++k) {
      const float ahead = pixel_depth[k] - depth[k];
      const float sdf = ahead * FusionPixel::scale_of(packed[k]);
      const int32_t reached = seen[k] & (sdf >= behind) & (ahead >= behind);
      measured->sdf[k] = sdf;
      measured->weight[k] = reached ? FusionPixel::weight_units_of(packed[k]) : 0;
    }
  }

  // Fuses row z of the columns, from voxel `first` on.
  template <int kLanes>
  KT_HOST_DEVICE void fuse_row(int64_t first, int z, const Measured<kLanes>& measured, int32_t* mask,
                               int32_t* any) const {
    const float per_metre = 1.0f / volume.truncation_m, colour_reach = kColourVoxels * volume.voxel_size_m,
                most_units = max_weight_units;
    float sdf[kLanes];
    int32_t weight[kLanes];
    for (int l = 0; l < kLanes; ++l) sdf[l] = measured.sdf[z * kLanes + l];
    for (int l = 0; l < kLanes; ++l) weight[l] = measured.weight[z * kLanes + l];
    // Arrays of their own between loads and stores: what a loop writes cannot alias what it reads.
    uint32_t words[kLanes];
    for (int l = 0; l < kLanes; ++l) words[l] = volume.voxels[first + l].word;
    float colour_weight[kLanes];
    int32_t fused[kLanes], near[kLanes];
    int32_t any_coloured = 0;
    for (int l = 0; l < kLanes; ++l) {
      const Voxel old{words[l]};
      const int32_t old_distance = old.distance(), old_units = old.weight_units();
      fused[l] = (weight[l] > 0) & !old.is_frozen();
      const auto w_old = static_cast<float>(old_units), w_new = static_cast<float>(weight[l]),
                 d_old = static_cast<float>(old_distance);
      const float tsdf = max_of(min_of(sdf[l] * per_metre, 1.0f), -1.0f);
      const float share = w_new / max_of(w_old + w_new, 1.0f);
      const float mean = floorf(d_old + share * (tsdf * Voxel::kDistanceUnits - d_old) + 0.5f);
      const float total = min_of(w_old + w_new, most_units);
      const int32_t distance = fused[l] ? static_cast<int32_t>(mean) : old_distance,
                    units = fused[l] ? static_cast<int32_t>(total) : old_units;
      near[l] = (units > 0) & (distance < kNearSurface);
      words[l] = Voxel::of(distance, units).word | (old.word & Voxel::kFrozen);
      const int32_t coloured = fused[l] & (fabsf(sdf[l]) < colour_reach);
      colour_weight[l] = coloured ? w_new : 0.0f;
      any_coloured |= coloured;
    }
    for (int l = 0; l < kLanes; ++l) volume.voxels[first + l].word = words[l];
    for (int l = 0; l < kLanes; ++l) any[l] |= fused[l];
    // Only what was fused: a voxel's bit must not hang on its neighbours in the lanes.
    for (int l = 0; l < kLanes; ++l) {
      const int32_t updated = (mask[l] & ~(1 << z)) | near[l] << z;
      mask[l] = fused[l] ? updated : mask[l];
    }
    if (any_coloured && colours)
      fuse_colours<kLanes>(measured.pixel + z * kLanes, colour_weight, volume.colours + first);
  }

  // The same running average for the colours of a row, by weights that are times the trust in the colour, in
  // whole units; a weight of 0 leaves one as it is.
  template <int kLanes>
  KT_HOST_DEVICE void fuse_colours(const int32_t* pixel, const float* weight, ColourVoxel* row) const {
    uint32_t rgba[kLanes];
    for (int l = 0; l < kLanes; ++l) rgba[l] = colours[pixel[l]];
    for (int l = 0; l < kLanes; ++l) {
      const ColourVoxel old = row[l];
      const auto w_old = static_cast<float>(old.weight_units());
      const float trust = static_cast<float>(static_cast<int32_t>(rgba[l] >> 24) + 1) * (1.0f / 256.0f);
      const float w_new = rgba[l] ? min_of(max_of(floorf(weight[l] * trust), 1.0f), weight[l]) : 0.0f;
      const float share = w_new / max_of(w_old + w_new, 1.0f);
      const auto blend = [share](int32_t mean, uint32_t level) {
        const auto old_value = static_cast<float>(mean);
        return static_cast<int32_t>(
            old_value + share * (static_cast<float>(static_cast<int32_t>(level << 8)) - old_value) + 0.5f);
      };
      row[l] = ColourVoxel::of(blend(old.r(), rgba[l] & 255), blend(old.g(), rgba[l] >> 8 & 255),
                               blend(old.b(), rgba[l] >> 16 & 255),
                               static_cast<int32_t>(min_of(w_old + w_new, max_weight_units)));
    }
  }
};

/// State of a fused brick from its columns; one in which the frame measured nothing stays as it is.
struct SummariseBrick {
  VolumeView volume;
  const int32_t* slots;
  const uint8_t* column_fused;
  uint32_t frame_sequence;

  KT_HOST_DEVICE void operator()(int64_t i) const {
    const int64_t slot = slots[i];
    uint8_t any_fused = 0, any_near = 0;
    for (int column = 0; column < kBrickColumns; ++column) {
      any_fused |= column_fused[i * kBrickColumns + column];
      any_near |= volume.surface_masks[slot * kBrickColumns + column];
    }
    if (!any_fused) return;
    volume.brick_states[slot] = any_near ? kBrickSurface : kBrickObserved;
    if (any_near) volume.brick_last_seen[slot] = frame_sequence;
  }
};

}  // namespace kt
