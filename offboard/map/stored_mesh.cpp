// Vertices as records of fixed size.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/map/stored_mesh.h"

#include <algorithm>
#include <vector>

#include "shared/core/check.h"

namespace kt {
namespace {

struct StoredVertex {
  Vec3f p, n;
  float quality = 0;
  Rgb8 colour;
  uint8_t unused = 0;
};
static_assert(sizeof(StoredVertex) == 32);

constexpr uint64_t kBlock = 1 << 16;  // values read at once

std::filesystem::path with_ending(std::filesystem::path path, const char* ending) {
  path += ending;
  return path;
}

// Calls visit with the `count` values of a file, some at a time.
template <typename T, typename Visit>
void for_each_block(const ScratchFile& file, uint64_t count, const Visit& visit) {
  for (uint64_t i = 0; i < count; i += kBlock)
    visit(file.values_at<T>(static_cast<int64_t>(i * sizeof(T)), std::min(kBlock, count - i)));
}

}  // namespace

StoredMesh::StoredMesh(const std::filesystem::path& scratch)
    : vertex_file_(with_ending(scratch, ".vertices"), "the vertices of the map"),
      triangle_file_(with_ending(scratch, ".triangles"), "the triangles of the map") {}

void StoredMesh::add_vertices(const Mesh& block) {
  const size_t count = block.vertices.size();
  KT_CHECK(block.normals.size() == count && block.colours.size() == count && block.quality.size() == count);
  std::vector<StoredVertex> stored(count);
  for (size_t i = 0; i < count; ++i)
    stored[i] = {block.vertices[i], block.normals[i], block.quality[i], block.colours[i], 0};
  vertex_file_.append(std::span<const StoredVertex>(stored));
  vertices_ += count;
}

void StoredMesh::add_triangles(std::span<const std::array<uint32_t, 3>> triangles) {
  triangle_file_.append(triangles);
  triangles_ += triangles.size();
}

MeshStream StoredMesh::stream() const {
  MeshStream stream{vertices_, triangles_, true, true, true, {}, {}};
  stream.for_each_vertices = [this](const MeshStream::TakeVertices& take) {
    for_each_block<StoredVertex>(vertex_file_, vertices_, [&](const std::vector<StoredVertex>& stored) {
      Mesh block;
      for (const StoredVertex& vertex : stored) {
        block.vertices.push_back(vertex.p);
        block.normals.push_back(vertex.n);
        block.colours.push_back(vertex.colour);
        block.quality.push_back(vertex.quality);
      }
      take(block);
    });
  };
  stream.for_each_triangles = [this](const MeshStream::TakeTriangles& take) {
    for_each_block<std::array<uint32_t, 3>>(triangle_file_, triangles_, take);
  };
  return stream;
}

}  // namespace kt
