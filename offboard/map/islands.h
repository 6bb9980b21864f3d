// Drops the small loose pieces of a mesh.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "shared/io/mesh.h"

namespace kt {

/// An island is what hangs together through common vertices. One smaller than either limit falls; 0 asks for
/// nothing.
struct IslandConfig {
  int64_t min_triangles = 30;
  double min_area_m2 = 0.001;  ///< a square of some 3 cm
};

struct IslandReport {
  int64_t islands = 0;  ///< before
  int64_t dropped_islands = 0;
  int64_t dropped_triangles = 0;
};

/// Takes the islands below the limits out of `mesh`, and vertices without a triangle; the rest keeps its
/// order. Which fall does not depend on the order, but for the rounding of areas.
IslandReport drop_small_islands(const IslandConfig& config, Mesh& mesh);

}  // namespace kt
