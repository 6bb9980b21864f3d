// Writes Wavefront OBJ.
// SPDX-License-Identifier: BSD-3-Clause
#include <charconv>

#include "shared/core/check.h"
#include "shared/io/file.h"
#include "shared/io/obj.h"

namespace kt {
namespace {

template <typename Number>
void append(std::string& text, Number value) {
  char digits[32];
  text.append(digits, std::to_chars(digits, digits + sizeof digits, value).ptr);
}

void append_all(std::string& text, Vec3f v) {
  for (const float value : {v.x, v.y, v.z}) {
    text += ' ';
    append(text, value);
  }
}

}  // namespace

std::string obj_bytes(const Mesh& mesh) {
  const size_t count = mesh.vertices.size();
  const bool has_normals = !mesh.normals.empty(), has_colours = !mesh.colours.empty();
  KT_CHECK(!has_normals || mesh.normals.size() == count);
  KT_CHECK(!has_colours || mesh.colours.size() == count);

  std::string text = "# metres\n";
  for (size_t i = 0; i < count; ++i) {
    text += 'v';
    append_all(text, mesh.vertices[i]);
    if (has_colours) {
      const auto [r, g, b] = mesh.colours[i];
      append_all(
          text, Vec3f{static_cast<float>(r) / 255, static_cast<float>(g) / 255, static_cast<float>(b) / 255});
    }
    text += '\n';
  }
  for (const Vec3f normal : mesh.normals) {
    text += "vn";
    append_all(text, normal);
    text += '\n';
  }
  for (const auto& triangle : mesh.triangles) {
    text += 'f';
    for (const uint32_t corner : triangle) {
      const uint64_t number = uint64_t{corner} + 1;  // OBJ counts from 1
      text += ' ';
      append(text, number);
      if (has_normals) {
        text += "//";
        append(text, number);
      }
    }
    text += '\n';
  }
  return text;
}

void write_obj(const std::filesystem::path& path, const Mesh& mesh) { write_file(path, obj_bytes(mesh)); }

}  // namespace kt
