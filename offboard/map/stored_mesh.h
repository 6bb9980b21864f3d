// A mesh in files, for one that is too large for memory.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <span>

#include "shared/core/scratch_file.h"
#include "shared/io/mesh_stream.h"

namespace kt {

class StoredMesh {
 public:
  /// Makes two files, `scratch` with ".vertices" and ".triangles" behind it, removed in the end: 32 bytes for
  /// each vertex, 12 for each triangle. Throws kt::Error as ScratchFile.
  explicit StoredMesh(const std::filesystem::path& scratch);

  /// Appends the vertices of `block`, which has normals, colours and quality.
  void add_vertices(const Mesh& block);
  /// Appends triangles, as indices into all vertices.
  void add_triangles(std::span<const std::array<uint32_t, 3>> triangles);

  uint64_t vertices() const { return vertices_; }
  uint64_t triangles() const { return triangles_; }
  /// The mesh in blocks of some megabytes; *this has to live as long.
  MeshStream stream() const;

 private:
  ScratchFile vertex_file_, triangle_file_;
  uint64_t vertices_ = 0, triangles_ = 0;
};

}  // namespace kt
