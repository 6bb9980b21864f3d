// Writes binary little-endian PLY.
// SPDX-License-Identifier: BSD-3-Clause
#include <bit>

#include "shared/io/file.h"
#include "shared/io/ply.h"

namespace kt {
namespace {

static_assert(std::endian::native == std::endian::little, "the writer copies values as they lie in memory");

std::string header_of(const MeshStream& mesh) {
  std::string header = "ply\nformat binary_little_endian 1.0\ncomment metres\n";
  header += "element vertex " + std::to_string(mesh.vertices) +
            "\nproperty float x\nproperty float y\nproperty float z\n";
  if (mesh.has_normals) header += "property float nx\nproperty float ny\nproperty float nz\n";
  if (mesh.has_colours) header += "property uchar red\nproperty uchar green\nproperty uchar blue\n";
  if (mesh.has_quality) header += "property float quality\n";
  return header + "element face " + std::to_string(mesh.triangles) +
         "\nproperty list uchar int vertex_indices\nend_header\n";
}

}  // namespace

void write_ply(const MeshStream& mesh, const ByteSink& sink) {
  ByteBlocks out(sink);
  out.text(header_of(mesh));
  mesh.for_each_vertices([&](const Mesh& block) {
    for (size_t i = 0; i < block.vertices.size(); ++i) {
      out.put(block.vertices[i]);
      if (mesh.has_normals) out.put(block.normals[i]);
      if (mesh.has_colours) out.put(block.colours[i]);
      if (mesh.has_quality) out.put(block.quality[i]);
    }
  });
  mesh.for_each_triangles([&](std::span<const std::array<uint32_t, 3>> block) {
    for (const auto& triangle : block) {
      out.put(uint8_t{3});
      out.put(triangle);
    }
  });
  out.flush();
}

std::string ply_bytes(const Mesh& mesh) {
  return gathered_bytes([&](const ByteSink& sink) { write_ply(stream_of(mesh), sink); });
}

void write_ply(const std::filesystem::path& path, const Mesh& mesh) {
  OutputFile file(path);
  write_ply(stream_of(mesh), [&file](std::string_view bytes) { file.write(bytes); });
  file.close();
}

}  // namespace kt
