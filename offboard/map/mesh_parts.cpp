// Lists appended and compacted in place.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/map/mesh_parts.h"

#include <cstdint>
#include <limits>

#include "shared/core/check.h"

namespace kt {

Mesh concatenated(std::span<const Mesh> meshes) {
  Mesh all;
  bool has_normals = true, has_colours = true, has_quality = true;
  for (const Mesh& mesh : meshes) {
    const size_t count = mesh.vertices.size();
    has_normals &= mesh.normals.size() == count;
    has_colours &= mesh.colours.size() == count;
    has_quality &= mesh.quality.size() == count;
  }
  const auto append = [](auto& list, const auto& more) { list.insert(list.end(), more.begin(), more.end()); };
  for (const Mesh& mesh : meshes) {
    const size_t start = all.vertices.size();
    KT_CHECK(start + mesh.vertices.size() < std::numeric_limits<uint32_t>::max(), "too many vertices");
    append(all.vertices, mesh.vertices);
    if (has_normals) append(all.normals, mesh.normals);
    if (has_colours) append(all.colours, mesh.colours);
    if (has_quality) append(all.quality, mesh.quality);
    const auto offset = static_cast<uint32_t>(start);
    for (const auto& [a, b, c] : mesh.triangles)
      all.triangles.push_back({a + offset, b + offset, c + offset});
  }
  return all;
}

std::vector<bool> keep_triangles(const std::vector<bool>& stands, Mesh& mesh) {
  KT_CHECK(stands.size() == mesh.triangles.size());
  keep_values(stands, mesh.triangles);
  return drop_unused_vertices(mesh);
}

void keep_triangles(const std::vector<bool>& stands, WeldedMesh& mesh) {
  keep_values(keep_triangles(stands, static_cast<Mesh&>(mesh)), mesh.keys);
}

std::vector<bool> drop_unused_vertices(Mesh& mesh) {
  std::vector<bool> is_used(mesh.vertices.size());
  for (const auto& triangle : mesh.triangles) {
    for (const uint32_t corner : triangle) is_used[corner] = true;
  }
  std::vector<uint32_t> new_index(mesh.vertices.size());
  uint32_t count = 0;
  for (size_t i = 0; i < is_used.size(); ++i) {
    if (is_used[i]) new_index[i] = count++;
  }
  const auto compact = [&](auto& list) {
    if (!list.empty()) keep_values(is_used, list);
  };
  compact(mesh.vertices);
  compact(mesh.normals);
  compact(mesh.colours);
  compact(mesh.quality);
  for (auto& triangle : mesh.triangles) {
    for (uint32_t& corner : triangle) corner = new_index[corner];
  }
  return is_used;
}

}  // namespace kt
