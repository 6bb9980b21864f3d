// Kernels that copy whole bricks out of the volume and back into it.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "onboard/fusion/slice_kernel.h"

namespace kt {

/// All that the volume knows of one brick, to be kept outside it.
struct alignas(8) StoredBrick {
  Vec3i brick;  ///< global
  uint32_t last_seen = 0;
  uint8_t state = kBrickEmpty, unused[7] = {};
  uint8_t surface_masks[kBrickColumns] = {};
  Voxel voxels[kBrickVoxels];
  ColourVoxel colours[kBrickVoxels];
};
static_assert(sizeof(StoredBrick) == 24 + kBrickColumns + kBrickVoxels * 12, "no byte of it is undefined");

/// Flags the bricks outside `after` that were ever fused into, and apart from them those that hold surface;
/// by slot.
struct SelectLeavingBrick {
  VolumeView volume;  // before the move
  VoxelBounds after;
  uint8_t *leaving, *with_surface;  // out

  KT_HOST_DEVICE void operator()(int64_t slot) const {
    const Vec3i b = volume.brick(slot);
    const Vec3i low = Vec3i{b.x * kBrickSide, b.y * kBrickSide, b.z * kBrickSide} + volume.origin_voxel();
    const bool leaves = volume.brick_states[slot] != kBrickEmpty && !after.contains(low);
    leaving[slot] = leaves ? 1 : 0;
    with_surface[slot] = leaves && volume.brick_states[slot] == kBrickSurface ? 1 : 0;
  }
};

/// Copies row by row of 8 voxels; elements are the 64 rows of each brick, which has as many columns.
struct StoreBrickRow {
  VolumeView volume;
  const int32_t* slots;
  StoredBrick* bricks;  // out

  KT_HOST_DEVICE void operator()(int64_t i) const {
    const int64_t slot = slots[i / kBrickColumns];
    const int row = static_cast<int>(i % kBrickColumns);
    StoredBrick& out = bricks[i / kBrickColumns];
    if (row == 0) {
      out.brick = volume.brick(slot) + volume.origin_brick;
      out.last_seen = volume.brick_last_seen[slot];
      out.state = volume.brick_states[slot];
    }
    out.surface_masks[row] = volume.surface_masks[slot * kBrickColumns + row];
    for (int x = row * kBrickSide; x < (row + 1) * kBrickSide; ++x) {
      out.voxels[x] = volume.voxels[slot * kBrickVoxels + x];
      out.colours[x] = volume.colours[slot * kBrickVoxels + x];
    }
  }
};

/// The way back, to bricks that lie in the volume.
struct RestoreBrickRow {
  VolumeView volume;
  const StoredBrick* bricks;

  KT_HOST_DEVICE void operator()(int64_t i) const {
    const StoredBrick& in = bricks[i / kBrickColumns];
    const int row = static_cast<int>(i % kBrickColumns);
    const int64_t slot = volume.slot(in.brick - volume.origin_brick);
    if (row == 0) {
      volume.brick_last_seen[slot] = in.last_seen;
      volume.brick_states[slot] = in.state;
    }
    volume.surface_masks[slot * kBrickColumns + row] = in.surface_masks[row];
    for (int x = row * kBrickSide; x < (row + 1) * kBrickSide; ++x) {
      volume.voxels[slot * kBrickVoxels + x] = in.voxels[x];
      volume.colours[slot * kBrickVoxels + x] = in.colours[x];
    }
  }
};

}  // namespace kt
