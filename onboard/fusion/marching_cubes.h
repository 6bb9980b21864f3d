// The triangles of a cell for each of the 256 sign patterns of its corners.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "shared/core/vec.h"

namespace kt {

/// Corner c of a cell stands at (c & 1, c >> 1 & 1, c >> 2). Edge e runs along axis e / 4 from the corner
/// returned by `edge_start`. Bit c of a pattern is set where corner c lies inside (tsdf < 0).
struct MarchingCubesTable {
  static constexpr int kMaxTriangles = 5;
  uint8_t triangle_count[256] = {};
  uint8_t edges[256][3 * kMaxTriangles] = {};  ///< counter-clockwise seen from outside

  KT_HOST_DEVICE static int edge_axis(int edge) { return edge / 4; }
  KT_HOST_DEVICE static Vec3i edge_start(int edge) {
    const int a = edge & 1, b = edge >> 1 & 1;
    switch (edge / 4) {
      case 0:
        return {0, a, b};
      case 1:
        return {a, 0, b};
      default:
        return {a, b, 0};
    }
  }
};

/// Derives the table instead of listing it (Lorensen and Cline 1987): on each face, the contour separates
/// every run of inside corners from the rest. That depends on the signs of the face alone, so neighbouring
/// cells always agree and no crack opens.
MarchingCubesTable make_marching_cubes_table();

}  // namespace kt
