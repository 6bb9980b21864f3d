// How well the colours of a map match those of the true surface.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>

#include "shared/geometry/se3.h"
#include "shared/io/mesh.h"
#include "tools/eval/statistics.h"

namespace kt {

/// In grey levels of 255; channels in the order red, green, blue.
struct ColourError {
  /// By which the map's levels were multiplied first: no camera knows how bright the world is.
  std::array<double, 3> factor{1, 1, 1};
  std::array<Statistics, 3> levels;  ///< |map - truth| of the compared vertices
  double mean = 0;                   ///< of all channels
  int64_t compared = 0;              ///< vertices of the map with a point of the truth near by
};

/// Compares each vertex of `map`, placed by `T_groundtruth_map`, with the nearest point of `truth`, a cloud
/// with colours; those without one within `reach_m` do not count. Throws kt::Error where either has no
/// colours, or nothing is compared.
ColourError colour_error(const Mesh& map, const Mesh& truth, const Pose& T_groundtruth_map,
                         double reach_m = 0.015);

}  // namespace kt
