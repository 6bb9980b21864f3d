// One vertex of a cloud slice, and the key that welds it; plain data, so kernels write it.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
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

/// The cell of the voxel grid, by its lowest corner, that a triangle of marching cubes lies in: the only one
/// that has all three edges.
inline Vec3i owning_cell(const std::array<EdgeKey, 3>& corners) {
  Vec3i cell{-EdgeKey::kLimit, -EdgeKey::kLimit, -EdgeKey::kLimit};
  for (const EdgeKey key : corners) {
    // The cells around an edge begin at its first voxel or one before, but not before it along its axis.
    const Vec3i voxel = key.voxel();
    cell.x = std::max(cell.x, voxel.x - (key.axis() != 0));
    cell.y = std::max(cell.y, voxel.y - (key.axis() != 1));
    cell.z = std::max(cell.z, voxel.z - (key.axis() != 2));
  }
  return cell;
}

struct SliceVertex {
  EdgeKey key;
  Vec3f p_odom;  ///< position (m)
  Vec3f n_odom;  ///< unit outward normal
  Rgb8 colour;
  float weight = 0;            ///< fused observations behind it, in units of one head-on view at 1 m
  uint32_t pose_sequence = 0;  ///< sequence of the frame that last saw it
};

}  // namespace kt
