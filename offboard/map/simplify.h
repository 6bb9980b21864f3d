// A mesh of fewer triangles that shows the same surface.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "shared/io/mesh.h"

namespace kt {

/// Simplifying ends where either is reached.
struct SimplifyConfig {
  double keep_share = 0.25;  ///< of the triangles
  double max_error_m =
      std::numeric_limits<double>::infinity();  ///< root mean square distance to the planes merged
};

struct SimplifyReport {
  int64_t collapsed_edges = 0;
  double largest_error_m = 0;        ///< of any collapse, as max_error_m
  std::vector<bool> is_vertex_kept;  ///< by vertex of the mesh as it was
};

/// Collapses edges in the order of their quadric error (Garland and Heckbert 1997), of equals the one of the
/// lower vertices, the shorter first where the surface is flat. Vertices on a border, or on an edge of more
/// than two triangles, stay where they are. A collapse that would fold the surface over or change how it
/// hangs together is not done. The vertex that stays is placed where the error is least; its normal, colour
/// and quality lie between those of the two, in proportion. The error is of shape alone: on a flat wall the
/// detail of colours goes with the triangles. Vertices and triangles that remain keep their order; the same
/// mesh gives the same bytes. Vertices whose entry in `is_pinned` is true (empty: none) stay too, and no two
/// of them are newly joined by an edge: other meshes hang on them, and may have that edge.
///
/// Takes some 250 bytes per triangle for as long as it runs. Fewer than 2^32 / 3 triangles.
SimplifyReport simplify(const SimplifyConfig& config, Mesh& mesh, const std::vector<bool>& is_pinned = {});

}  // namespace kt
