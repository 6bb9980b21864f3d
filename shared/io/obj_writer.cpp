// Writes Wavefront OBJ.
// SPDX-License-Identifier: BSD-3-Clause
#include <charconv>

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

void write_obj(const MeshStream& mesh, const ByteSink& sink) {
  ByteBlocks out(sink);
  std::string line = "# metres";
  const auto end_line = [&] {
    line += '\n';
    out.text(line);
    line.clear();
  };
  end_line();
  mesh.for_each_vertices([&](const Mesh& block) {
    for (size_t i = 0; i < block.vertices.size(); ++i) {
      line += 'v';
      append_all(line, block.vertices[i]);
      if (mesh.has_colours) {
        const auto [r, g, b] = block.colours[i];
        append_all(line, Vec3f{static_cast<float>(r) / 255, static_cast<float>(g) / 255,
                               static_cast<float>(b) / 255});
      }
      end_line();
    }
  });
  mesh.for_each_vertices([&](const Mesh& block) {
    for (const Vec3f normal : block.normals) {
      line += "vn";
      append_all(line, normal);
      end_line();
    }
  });
  mesh.for_each_triangles([&](std::span<const std::array<uint32_t, 3>> block) {
    for (const auto& triangle : block) {
      line += 'f';
      for (const uint32_t corner : triangle) {
        const uint64_t number = uint64_t{corner} + 1;  // OBJ counts from 1
        line += ' ';
        append(line, number);
        if (!mesh.has_normals) continue;
        line += "//";
        append(line, number);
      }
      end_line();
    }
  });
  out.flush();
}

std::string obj_bytes(const Mesh& mesh) {
  return gathered_bytes([&](const ByteSink& sink) { write_obj(stream_of(mesh), sink); });
}

}  // namespace kt
