// The cubes that a map is cut into, so that it need not be held whole.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <compare>
#include <cstdint>

#include "shared/types/slice_vertex.h"

namespace kt {

/// A cube of a patch: of what was welded by the keys of one voxel grid.
struct TileId {
  int32_t patch = 0;
  int32_t z = 0, y = 0, x = 0;
  friend auto operator<=>(const TileId&, const TileId&) = default;
};

struct TileGrid {
  int32_t side = 256;  ///< of a cube, in cells; at least 2

  TileId tile_of(int32_t patch, Vec3i cell) const {
    return {patch, cube(cell.z), cube(cell.y), cube(cell.x)};
  }
  /// Whether a cell lies in a cube, or no more than `margin` cells beside it.
  bool is_within(const TileId& id, Vec3i cell, int32_t margin) const {
    const auto is_near = [&](int32_t a, int32_t at) {
      return a >= at * side - margin && a < (at + 1) * side + margin;
    };
    return is_near(cell.x, id.x) && is_near(cell.y, id.y) && is_near(cell.z, id.z);
  }
  /// Whether all cells around an edge lie so.
  bool is_within(const TileId& id, EdgeKey key, int32_t margin) const {
    const Vec3i v = key.voxel();
    return is_within(id, v, margin) && is_within(id, v - Vec3i{1, 1, 1}, margin);
  }
  /// Whether cells of several cubes meet in the edge, so that its vertex may stand in several tiles.
  bool is_shared(EdgeKey key) const {
    const Vec3i v = key.voxel();
    const int axis = key.axis();
    return (axis != 0 && begins_cube(v.x)) || (axis != 1 && begins_cube(v.y)) ||
           (axis != 2 && begins_cube(v.z));
  }

 private:
  int32_t cube(int32_t a) const { return a / side - (a % side < 0); }
  bool begins_cube(int32_t a) const { return a % side == 0; }
};

}  // namespace kt
