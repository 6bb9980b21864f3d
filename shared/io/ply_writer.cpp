// Writes binary little-endian PLY.
// SPDX-License-Identifier: BSD-3-Clause
#include <bit>
#include <cstring>

#include "shared/core/check.h"
#include "shared/io/file.h"
#include "shared/io/ply.h"

namespace kt {
namespace {

static_assert(std::endian::native == std::endian::little, "the writer copies values as they lie in memory");

class Bytes {
 public:
  explicit Bytes(char* at) : at_(at) {}
  template <typename T>
  void put(const T& value) {
    std::memcpy(at_, &value, sizeof value);
    at_ += sizeof value;
  }

 private:
  char* at_;
};

}  // namespace

std::string ply_bytes(const Mesh& mesh) {
  const size_t count = mesh.vertices.size();
  const bool has_normals = !mesh.normals.empty(), has_colours = !mesh.colours.empty();
  const bool has_quality = !mesh.quality.empty();
  KT_CHECK(!has_normals || mesh.normals.size() == count);
  KT_CHECK(!has_colours || mesh.colours.size() == count);
  KT_CHECK(!has_quality || mesh.quality.size() == count);

  std::string file = "ply\nformat binary_little_endian 1.0\ncomment metres\n";
  file +=
      "element vertex " + std::to_string(count) + "\nproperty float x\nproperty float y\nproperty float z\n";
  if (has_normals) file += "property float nx\nproperty float ny\nproperty float nz\n";
  if (has_colours) file += "property uchar red\nproperty uchar green\nproperty uchar blue\n";
  if (has_quality) file += "property float quality\n";
  file += std::string("element face ") + std::to_string(mesh.triangles.size()) +
          "\nproperty list uchar int vertex_indices\nend_header\n";

  const size_t vertex_size = 12 + (has_normals ? 12 : 0) + (has_colours ? 3 : 0) + (has_quality ? 4 : 0);
  const size_t header_size = file.size();
  file.resize(header_size + count * vertex_size + mesh.triangles.size() * 13);
  Bytes out(file.data() + header_size);
  for (size_t i = 0; i < count; ++i) {
    out.put(mesh.vertices[i]);
    if (has_normals) out.put(mesh.normals[i]);
    if (has_colours) out.put(mesh.colours[i]);
    if (has_quality) out.put(mesh.quality[i]);
  }
  for (const auto& triangle : mesh.triangles) {
    out.put(uint8_t{3});
    out.put(triangle);
  }
  return file;
}

void write_ply(const std::filesystem::path& path, const Mesh& mesh) { write_file(path, ply_bytes(mesh)); }

}  // namespace kt
