// One vertex of a cloud slice, and the key that welds it; plain data, so kernels write it.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <compare>
#include <cstdint>

#include "shared/core/image.h"
#include "shared/core/vec.h"

namespace kt {

/// Names the voxel edge a vertex lies on, the same in every slice: from voxel (x, y, z) of the endless odom
/// grid to its neighbour along `axis`. Neighbouring slices weld by it.
struct EdgeKey {
  uint64_t bits = 0;

  static constexpr int kAxisBits = 20;
  static constexpr int32_t kLimit =
      1 << (kAxisBits - 1);  ///< coordinates lie in [-kLimit, kLimit): +-5 km at 1 cm

  KT_HOST_DEVICE static EdgeKey of(Vec3i voxel, int axis) {
    const auto field = [](int32_t coordinate, int shift) {
      return static_cast<uint64_t>(coordinate + kLimit) << shift;
    };
    return {field(voxel.z, 2 + 2 * kAxisBits) | field(voxel.y, 2 + kAxisBits) | field(voxel.x, 2) |
            static_cast<uint64_t>(axis)};
  }
  KT_HOST_DEVICE Vec3i voxel() const {
    const auto coordinate = [this](int shift) {
      return static_cast<int32_t>(bits >> shift & ((1u << kAxisBits) - 1)) - kLimit;
    };
    return {coordinate(2), coordinate(2 + kAxisBits), coordinate(2 + 2 * kAxisBits)};
  }
  KT_HOST_DEVICE int axis() const { return static_cast<int>(bits & 3); }
  friend auto operator<=>(const EdgeKey&, const EdgeKey&) = default;
};

struct SliceVertex {
  EdgeKey key;
  Vec3f p_odom;  ///< position (m)
  Vec3f n_odom;  ///< unit outward normal
  Rgb8 colour;
  float weight = 0;            ///< fused observations behind it, in units of one head-on view at 1 m
  uint32_t pose_sequence = 0;  ///< sequence of the frame that last saw it
};

}  // namespace kt
