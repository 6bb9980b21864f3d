// Meshes put together and thinned out.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include "shared/io/mesh.h"

namespace kt {

/// One mesh of all, in their order, nothing joined. What one that has vertices lacks (normals, colours,
/// quality), the result lacks. Fewer than 2^32 vertices in all.
Mesh concatenated(std::span<const Mesh> meshes);

/// Keeps the triangles whose entry in `stands` is true, in their order, and the vertices that they use, in
/// theirs.
void keep_triangles(const std::vector<bool>& stands, Mesh& mesh);

/// Makes one vertex, the first, of those whose positions are equal bit for bit: what copies of a key in one
/// stay are once they are deformed. Triangles that lose a corner by it go, and vertices without a triangle.
/// Sheets that touch in a point are joined as well.
void join_coincident(Mesh& mesh);

/// Vertices without a triangle go; the rest keep their order, so triangles keep theirs.
void drop_unused_vertices(Mesh& mesh);

}  // namespace kt
