// Memory layout of the moving volume: voxels in bricks, bricks in a ring.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "shared/core/vec.h"

namespace kt {

/// Truncated signed distance and trust of one voxel, in one word, which kernels handle as SIMD.
struct Voxel {
  static constexpr float kDistanceUnits = 32767.0f;  ///< of one truncation distance
  static constexpr float kWeightUnits = 128.0f;      ///< of weight 1 (one head-on view at 1 m)
  /// Flag: shared with an exported slice, must not change any more.
  static constexpr uint32_t kFrozen = 0x8000'0000;

  uint32_t word = 0;  // distance units in the lower half, then 15 bits of weight units, then the flag

  /// Distance in [-kDistanceUnits, kDistanceUnits], weight in [0, 32767]; not frozen.
  KT_HOST_DEVICE static Voxel of(int32_t distance, int32_t weight_units) {
    return {(static_cast<uint32_t>(distance) & 0xffff) | static_cast<uint32_t>(weight_units) << 16};
  }
  KT_HOST_DEVICE int32_t distance() const { return static_cast<int32_t>(word << 16) >> 16; }
  KT_HOST_DEVICE int32_t weight_units() const { return static_cast<int32_t>(word >> 16 & 0x7fff); }
  KT_HOST_DEVICE bool is_frozen() const { return static_cast<int32_t>(word) < 0; }
  /// In truncation distances, [-1, 1], positive in front of the surface.
  KT_HOST_DEVICE float tsdf() const { return static_cast<float>(distance()) / kDistanceUnits; }
  KT_HOST_DEVICE float weight() const { return static_cast<float>(weight_units()) / kWeightUnits; }
};
static_assert(sizeof(Voxel) == 4);

/// Mean colour of one voxel in 1/256 levels, and its weight as in Voxel; in two words, as Voxel is in one.
struct alignas(8) ColourVoxel {
  uint32_t r_and_g = 0, b_and_weight = 0;  // the first of each in the lower half

  KT_HOST_DEVICE static ColourVoxel of(int32_t r, int32_t g, int32_t b, int32_t weight_units) {
    return {static_cast<uint32_t>(r) | static_cast<uint32_t>(g) << 16,
            static_cast<uint32_t>(b) | static_cast<uint32_t>(weight_units) << 16};
  }
  KT_HOST_DEVICE int32_t r() const { return static_cast<int32_t>(r_and_g & 0xffff); }
  KT_HOST_DEVICE int32_t g() const { return static_cast<int32_t>(r_and_g >> 16); }
  KT_HOST_DEVICE int32_t b() const { return static_cast<int32_t>(b_and_weight & 0xffff); }
  KT_HOST_DEVICE int32_t weight_units() const { return static_cast<int32_t>(b_and_weight >> 16); }
};
static_assert(sizeof(ColourVoxel) == 8);

inline constexpr int kLog2BrickSide = 3;
inline constexpr int kBrickSide = 1 << kLog2BrickSide;         // voxels
inline constexpr int kBrickColumns = kBrickSide * kBrickSide;  // columns of 8 voxels along z
inline constexpr int kBrickVoxels = kBrickColumns * kBrickSide;
inline constexpr int kBlockSide = 4;  // bricks; volumes and shifts come in whole blocks
inline constexpr int kBlockVoxels = kBrickSide * kBlockSide;

enum BrickState : uint8_t {
  kBrickEmpty = 0,     // never fused: all zero
  kBrickObserved = 1,  // fused, but holds no voxel near a surface
  kBrickSurface = 2,   // holds a voxel within the truncation distance of a surface
};

/// The volume as kernels see it. `local` coordinates count from the volume's lowest corner, `global` ones
/// from the origin of the odom frame; voxel (i, j, k) has its centre at (i, j, k) * voxel_size_m.
struct VolumeView {
  Voxel* voxels = nullptr;
  ColourVoxel* colours = nullptr;
  uint8_t* surface_masks = nullptr;     // by slot and column (x, y): bit z = that voxel is near a surface
  uint8_t* brick_states = nullptr;      // BrickState by slot
  uint32_t* brick_last_seen = nullptr;  // sequence of the frame that last saw a surface in the brick, by slot
  int32_t bricks = 0;                   // per axis
  Vec3i origin_brick;                   // global brick of the lowest corner, a multiple of kBlockSide
  Vec3i ring_origin;                    // origin_brick modulo bricks
  float voxel_size_m = 0, truncation_m = 0;

  KT_HOST_DEVICE int voxels_per_axis() const { return bricks * kBrickSide; }
  KT_HOST_DEVICE Vec3i origin_voxel() const {
    return {origin_brick.x * kBrickSide, origin_brick.y * kBrickSide, origin_brick.z * kBrickSide};
  }
  KT_HOST_DEVICE int wrap(int ring) const { return ring >= bricks ? ring - bricks : ring; }
  /// Brick of a voxel.
  KT_HOST_DEVICE static Vec3i brick_of(Vec3i v) {
    return {v.x >> kLog2BrickSide, v.y >> kLog2BrickSide, v.z >> kLog2BrickSide};
  }
  /// Slot of a local brick.
  KT_HOST_DEVICE int64_t slot(Vec3i b) const {
    return (int64_t{wrap(b.z + ring_origin.z)} * bricks + wrap(b.y + ring_origin.y)) * bricks +
           wrap(b.x + ring_origin.x);
  }
  /// Local brick of a slot.
  KT_HOST_DEVICE Vec3i brick(int64_t slot) const {
    const int rx = static_cast<int>(slot % bricks), ry = static_cast<int>(slot / bricks % bricks),
              rz = static_cast<int>(slot / bricks / bricks);
    const int x = rx - ring_origin.x, y = ry - ring_origin.y, z = rz - ring_origin.z;
    return {x < 0 ? x + bricks : x, y < 0 ? y + bricks : y, z < 0 ? z + bricks : z};
  }
  /// Index of a local voxel; it must lie inside.
  KT_HOST_DEVICE int64_t index(Vec3i v) const {
    return slot(brick_of(v)) * kBrickVoxels + ((v.z & 7) * kBrickSide + (v.y & 7)) * kBrickSide + (v.x & 7);
  }
  KT_HOST_DEVICE bool contains(Vec3i v) const {
    const auto n = static_cast<uint32_t>(voxels_per_axis());
    return static_cast<uint32_t>(v.x) < n && static_cast<uint32_t>(v.y) < n && static_cast<uint32_t>(v.z) < n;
  }
};

}  // namespace kt
