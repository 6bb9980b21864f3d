// Counts where a mesh shows one surface twice.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "shared/io/mesh.h"

namespace kt {

inline constexpr double kNearestLayer_m =
    0.02;  ///< what agrees nearer than this is one surface and its noise
inline constexpr double kFarthestLayer_m = 0.10;  ///< and what lies farther is another surface

struct DoubleLayers {
  int64_t vertices = 0;  ///< that a triangle uses
  int64_t doubled = 0;   ///< of these, that have another layer beside them
  double share() const {
    return vertices > 0 ? static_cast<double>(doubled) / static_cast<double>(vertices) : 0;
  }
};

/// A vertex is doubled where the next surface along its normal, before it or behind it, faces the same way:
/// within 45 degrees, 2 to 10 cm away. A line through solid bodies goes in and out by turns, so the next
/// surface of a true map faces the other way, as the back of a thin wall does; the same way twice means that
/// a layer is there twice. What agrees within 2 cm is passed over; what opposes ends the search at any
/// distance, so that a wall behind a board is no second layer of it. A surface that was never seen from
/// behind gives the one false alarm: a board without back closely before a wall that was seen behind it. How
/// two layers are joined elsewhere does not matter, so one that winds into another is found as well. Does not
/// depend on the order of vertices and triangles, nor on `threads` (0 = one per core). The mesh has normals.
DoubleLayers count_double_layers(const Mesh& mesh, int threads = 0);

}  // namespace kt
