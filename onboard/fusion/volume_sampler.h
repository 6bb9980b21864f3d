// Reads the volume between its voxels.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "onboard/fusion/grid.h"

namespace kt {

/// Trilinear samples of the volume at kLanes positions in local voxel units.
struct VolumeSampler {
  VolumeView volume;

  template <int kLanes>
  struct Samples {
    float tsdf[kLanes];
    Vec3fs<kLanes> gradient;   // per voxel
    int32_t observed[kLanes];  // 0 where a corner of the cell is unobserved or outside
  };

  /// Reads nothing for lanes that are not wanted.
  template <int kLanes>
  KT_HOST_DEVICE void sample(const Vec3fs<kLanes>& g, const int32_t* wanted, Samples<kLanes>* samples) const {
    const float limit = static_cast<float>(volume.voxels_per_axis() - 1);
    int32_t inside[kLanes];
    Vec3fs<kLanes> share;  // of the way to the next voxel
    Corners<kLanes> x, y, z;
    const int32_t along_y = volume.bricks, along_z = volume.bricks * volume.bricks;
    for (int l = 0; l < kLanes; ++l) {
      inside[l] = (wanted[l] != 0) & (g.x[l] >= 0.0f) & (g.y[l] >= 0.0f) & (g.z[l] >= 0.0f) &
                  (g.x[l] < limit) & (g.y[l] < limit) & (g.z[l] < limit);
      share.x[l] = x.set(l, inside[l] ? g.x[l] : 0.0f, volume, volume.ring_origin.x, 1, 1);
      share.y[l] = y.set(l, inside[l] ? g.y[l] : 0.0f, volume, volume.ring_origin.y, along_y, kBrickSide);
      share.z[l] = z.set(l, inside[l] ? g.z[l] : 0.0f, volume, volume.ring_origin.z, along_z, kBrickColumns);
    }
    uint32_t words[8][kLanes];
    for (int k = 0; k < 8; ++k) {
      const int kx = k & 1, ky = k >> 1 & 1, kz = k >> 2;
      int32_t slot[kLanes], offset[kLanes];
      for (int l = 0; l < kLanes; ++l) slot[l] = x.slot[kx][l] + y.slot[ky][l] + z.slot[kz][l];
      for (int l = 0; l < kLanes; ++l) offset[l] = x.offset[kx][l] + y.offset[ky][l] + z.offset[kz][l];
      for (int l = 0; l < kLanes; ++l) {
        words[k][l] = inside[l] ? volume.voxels[int64_t{slot[l]} * kBrickVoxels + offset[l]].word : 0;
      }
    }
    for (int l = 0; l < kLanes; ++l) {
      float f[8];
      int32_t observed = inside[l];
      KT_UNROLL for (int k = 0; k < 8; ++k) {
        const Voxel voxel{words[k][l]};
        f[k] = static_cast<float>(voxel.distance()) * (1.0f / Voxel::kDistanceUnits);
        observed &= voxel.weight_units() > 0;
      }
      const float x1 = share.x[l], y1 = share.y[l], z1 = share.z[l];
      const float f00 = f[0] + x1 * (f[1] - f[0]), f10 = f[2] + x1 * (f[3] - f[2]);
      const float f01 = f[4] + x1 * (f[5] - f[4]), f11 = f[6] + x1 * (f[7] - f[6]);
      const float f0 = f00 + y1 * (f10 - f00), f1 = f01 + y1 * (f11 - f01);
      const float dx0 = (f[1] - f[0]) + y1 * ((f[3] - f[2]) - (f[1] - f[0]));
      const float dx1 = (f[5] - f[4]) + y1 * ((f[7] - f[6]) - (f[5] - f[4]));
      samples->tsdf[l] = f0 + z1 * (f1 - f0);
      samples->gradient.x[l] = dx0 + z1 * (dx1 - dx0);
      samples->gradient.y[l] = (f10 - f00) + z1 * ((f11 - f01) - (f10 - f00));
      samples->gradient.z[l] = f1 - f0;
      samples->observed[l] = observed;
    }
  }

 private:
  // What the voxels below and above a position contribute, along one axis, to slot and offset in the brick.
  template <int kLanes>
  struct Corners {
    int32_t slot[2][kLanes], offset[2][kLanes];

    /// Returns the share of the way from the lower to the upper one.
    KT_HOST_DEVICE float set(int l, float g, const VolumeView& volume, int32_t ring_origin,
                             int32_t slots_per_brick, int32_t voxels_per_step) {
      const auto lower = static_cast<int32_t>(g);
      KT_UNROLL for (int k = 0; k < 2; ++k) {
        const int32_t voxel = lower + k;
        slot[k][l] = volume.wrap((voxel >> kLog2BrickSide) + ring_origin) * slots_per_brick;
        offset[k][l] = (voxel & (kBrickSide - 1)) * voxels_per_step;
      }
      return g - static_cast<float>(lower);
    }
  };
};

}  // namespace kt
