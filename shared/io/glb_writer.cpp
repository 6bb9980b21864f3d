// Writes binary glTF 2.0 with tinygltf, which this file alone includes.
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <sstream>

#include "shared/core/check.h"
#include "shared/io/file.h"
#include "shared/io/glb.h"

#define TINYGLTF_IMPLEMENTATION
#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#define TINYGLTF_NO_EXTERNAL_IMAGE
#include <tiny_gltf.h>

namespace kt {
namespace {

static_assert(std::endian::native == std::endian::little, "the writer copies values as they lie in memory");

struct Rgba8 {
  uint8_t r, g, b, a;
};

// The inverse of sRGB's transfer curve (IEC 61966-2-1), for each byte.
std::array<uint8_t, 256> linear_of_srgb() {
  std::array<uint8_t, 256> table;
  for (size_t i = 0; i < table.size(); ++i) {
    const double c = static_cast<double>(i) / 255;
    const double linear = c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
    table[i] = static_cast<uint8_t>(std::floor(linear * 255 + 0.5));
  }
  return table;
}

// Appends values to the one buffer, as a view and an accessor of it, and returns the number of the accessor.
template <typename T>
int add_values(tinygltf::Model& model, const std::vector<T>& values, int target, int component, int type) {
  std::vector<unsigned char>& bytes = model.buffers.front().data;
  tinygltf::BufferView view;
  view.buffer = 0;
  view.byteOffset = bytes.size();
  view.byteLength = values.size() * sizeof(T);
  view.target = target;
  bytes.resize(bytes.size() + view.byteLength);
  std::memcpy(bytes.data() + view.byteOffset, values.data(), view.byteLength);

  tinygltf::Accessor accessor;
  accessor.bufferView = static_cast<int>(model.bufferViews.size());
  accessor.componentType = component;
  accessor.count = values.size() * sizeof(T) /
                   static_cast<size_t>(tinygltf::GetComponentSizeInBytes(static_cast<uint32_t>(component)) *
                                       tinygltf::GetNumComponentsInType(static_cast<uint32_t>(type)));
  accessor.type = type;
  model.bufferViews.push_back(std::move(view));
  model.accessors.push_back(std::move(accessor));
  return static_cast<int>(model.accessors.size()) - 1;
}

// The format wants the bounds of positions.
void set_bounds(const std::vector<Vec3f>& positions, tinygltf::Accessor& accessor) {
  Vec3f low = positions.front(), high = low;
  for (const Vec3f p : positions) {
    low = {min_of(low.x, p.x), min_of(low.y, p.y), min_of(low.z, p.z)};
    high = {max_of(high.x, p.x), max_of(high.y, p.y), max_of(high.z, p.z)};
  }
  accessor.minValues = {low.x, low.y, low.z};
  accessor.maxValues = {high.x, high.y, high.z};
}

void add_mesh(tinygltf::Model& model, const Mesh& mesh) {
  tinygltf::Primitive primitive;
  const auto add_vectors = [&](const std::vector<Vec3f>& vectors) {
    return add_values(model, vectors, TINYGLTF_TARGET_ARRAY_BUFFER, TINYGLTF_COMPONENT_TYPE_FLOAT,
                      TINYGLTF_TYPE_VEC3);
  };
  model.buffers.emplace_back();
  primitive.attributes["POSITION"] = add_vectors(mesh.vertices);
  set_bounds(mesh.vertices, model.accessors.back());
  if (!mesh.normals.empty()) primitive.attributes["NORMAL"] = add_vectors(mesh.normals);
  if (!mesh.colours.empty()) {
    const std::array<uint8_t, 256> linear = linear_of_srgb();
    std::vector<Rgba8> colours;
    colours.reserve(mesh.colours.size());
    // Four channels: each vertex has to begin at a multiple of four bytes.
    for (const Rgb8 c : mesh.colours) colours.push_back({linear[c.r], linear[c.g], linear[c.b], 255});
    primitive.attributes["COLOR_0"] = add_values(model, colours, TINYGLTF_TARGET_ARRAY_BUFFER,
                                                 TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE, TINYGLTF_TYPE_VEC4);
    model.accessors.back().normalized = true;
  }
  primitive.indices = add_values(model, mesh.triangles, TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER,
                                 TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT, TINYGLTF_TYPE_SCALAR);
  primitive.mode = TINYGLTF_MODE_TRIANGLES;
  primitive.material = 0;

  tinygltf::Material material;
  material.pbrMetallicRoughness.metallicFactor = 0;  // else a map looks like dark metal
  material.pbrMetallicRoughness.roughnessFactor = 1;
  model.materials.push_back(std::move(material));
  model.meshes.emplace_back().primitives.push_back(std::move(primitive));
  tinygltf::Node& node = model.nodes.emplace_back();
  node.name = "map";
  node.mesh = 0;
  node.rotation = {1, 0, 0, 0};  // x y z w
  model.scenes.front().nodes.push_back(0);
}

}  // namespace

std::string glb_bytes(const Mesh& mesh) {
  const size_t count = mesh.vertices.size();
  KT_CHECK(mesh.normals.empty() || mesh.normals.size() == count);
  KT_CHECK(mesh.colours.empty() || mesh.colours.size() == count);
  const size_t size = count * (12 + (mesh.normals.empty() ? 0 : 12) + (mesh.colours.empty() ? 0 : 4)) +
                      mesh.triangles.size() * 12;
  constexpr size_t kRoomForJson = 1 << 16;
  if (size > std::numeric_limits<uint32_t>::max() - kRoomForJson) {
    throw Error("the map has " + std::to_string(size >> 20) +
                " MiB, and a .glb file holds at most 4096: write it as .ply, or simplify it");
  }
  tinygltf::Model model;
  model.asset.version = "2.0";
  model.asset.generator = "Kintsugi";
  model.defaultScene = 0;
  model.scenes.emplace_back();
  if (!mesh.triangles.empty()) add_mesh(model, mesh);
  std::ostringstream out(std::ios::binary);
  KT_CHECK(tinygltf::TinyGLTF().WriteGltfSceneToStream(&model, out, false, true));
  return std::move(out).str();
}

void write_glb(const std::filesystem::path& path, const Mesh& mesh) { write_file(path, glb_bytes(mesh)); }

}  // namespace kt
