// Meshes put together and thinned out.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include "shared/io/mesh.h"
#include "shared/types/slice_vertex.h"

namespace kt {

/// A mesh whose vertices lie on edges of a voxel grid, each on another.
struct WeldedMesh : Mesh {
  std::vector<EdgeKey> keys;  ///< one per vertex, ascending
};

/// The cell that a triangle of marching cubes lies in.
inline Vec3i cell_of(const WeldedMesh& mesh, size_t triangle) {
  const auto [a, b, c] = mesh.triangles[triangle];
  return owning_cell({mesh.keys[a], mesh.keys[b], mesh.keys[c]});
}

/// One mesh of all, in their order, nothing joined. What one that has vertices lacks (normals, colours,
/// quality), the result lacks. Fewer than 2^32 vertices in all.
Mesh concatenated(std::span<const Mesh> meshes);

/// Keeps the triangles whose entry in `stands` is true, in their order, and the vertices that they use, in
/// theirs. Returns by vertex whether it was kept.
std::vector<bool> keep_triangles(const std::vector<bool>& stands, Mesh& mesh);
void keep_triangles(const std::vector<bool>& stands, WeldedMesh& mesh);

/// Vertices without a triangle go; the rest keep their order, so triangles keep theirs. Returns by vertex
/// whether it was kept.
std::vector<bool> drop_unused_vertices(Mesh& mesh);

/// Keeps the values whose entry in `is_kept` is true, in their order.
template <typename T>
void keep_values(const std::vector<bool>& is_kept, std::vector<T>& values) {
  size_t count = 0;
  for (size_t i = 0; i < is_kept.size(); ++i) {
    if (is_kept[i]) values[count++] = values[i];
  }
  values.resize(count);
}

}  // namespace kt
