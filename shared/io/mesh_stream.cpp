// Going over a mesh that is in memory, and what is told of any.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/io/mesh_stream.h"

#include "shared/core/check.h"

namespace kt {

MeshStream stream_of(const Mesh& mesh) {
  const size_t count = mesh.vertices.size();
  for (const size_t size : {mesh.normals.size(), mesh.colours.size(), mesh.quality.size()})
    KT_CHECK(size == 0 || size == count, "a list with some of the vertices");
  return {count,
          mesh.triangles.size(),
          !mesh.normals.empty(),
          !mesh.colours.empty(),
          !mesh.quality.empty(),
          [&mesh](const MeshStream::TakeVertices& take) { take(mesh); },
          [&mesh](const MeshStream::TakeTriangles& take) { take(mesh.triangles); }};
}

MeshBounds bounds_of(const MeshStream& mesh) {
  MeshBounds bounds;
  bool is_first = true;
  mesh.for_each_vertices([&](const Mesh& block) {
    for (const Vec3f p : block.vertices) {
      if (is_first) bounds = {p, p};
      is_first = false;
      Vec3f &low = bounds.low, &high = bounds.high;
      low = {min_of(low.x, p.x), min_of(low.y, p.y), min_of(low.z, p.z)};
      high = {max_of(high.x, p.x), max_of(high.y, p.y), max_of(high.z, p.z)};
    }
  });
  return bounds;
}

Digest mesh_digest(const MeshStream& mesh) {
  Digest digest;
  const auto add = [&digest](const auto& list) {
    digest.add_bytes(list.data(), list.size() * sizeof(list[0]));
  };
  const auto add_lists = [&](bool has, auto member) {
    digest.add(has ? mesh.vertices : uint64_t{0});
    mesh.for_each_vertices([&](const Mesh& block) { add(block.*member); });
  };
  add_lists(true, &Mesh::vertices);
  add_lists(mesh.has_normals, &Mesh::normals);
  add_lists(mesh.has_colours, &Mesh::colours);
  add_lists(mesh.has_quality, &Mesh::quality);
  digest.add(mesh.triangles);
  mesh.for_each_triangles(add);
  return digest;
}

}  // namespace kt
