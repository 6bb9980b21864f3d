// Writes binary glTF 2.0: a JSON text that lists the arrays, then the arrays one after the other.
// SPDX-License-Identifier: BSD-3-Clause
#include <array>
#include <bit>
#include <cmath>
#include <limits>

#include "nlohmann/json.hpp"

#include "shared/core/check.h"
#include "shared/io/glb.h"

namespace kt {
namespace {

static_assert(std::endian::native == std::endian::little, "the writer copies values as they lie in memory");

using Json = nlohmann::ordered_json;

// Numbers of the specification, sections 3.6, 3.7 and 4.4.
constexpr int kUnsignedByte = 5121, kUnsignedInt = 5125, kFloat = 5126;
constexpr int kArrayBuffer = 34962, kElementArrayBuffer = 34963;
constexpr int kTriangles = 4;
constexpr uint32_t kMagic = 0x46546C67, kVersion = 2, kJsonChunk = 0x4E4F534A, kBinaryChunk = 0x004E4942;

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

// Adds a view of the next `bytes` of the one buffer and an accessor to it; returns the accessor's number.
size_t add_array(Json& head, uint64_t bytes, int target, const Json& accessor) {
  uint64_t begin = 0;
  for (const Json& view : head["bufferViews"]) begin += view["byteLength"].get<uint64_t>();
  head["bufferViews"].push_back(
      {{"buffer", 0}, {"byteOffset", begin}, {"byteLength", bytes}, {"target", target}});
  head["accessors"].push_back(accessor);
  head["accessors"].back()["bufferView"] = head["bufferViews"].size() - 1;
  return head["accessors"].size() - 1;
}

void add_mesh(Json& head, const MeshStream& mesh, uint64_t body_bytes) {
  const auto accessor = [](int component, const char* type, uint64_t count) {
    return Json{{"componentType", component}, {"type", type}, {"count", count}};
  };
  head["buffers"].push_back({{"byteLength", body_bytes}});
  head["bufferViews"] = head["accessors"] = Json::array();
  Json attributes;
  Json positions = accessor(kFloat, "VEC3", mesh.vertices);
  const auto [low, high] = bounds_of(mesh);  // the format wants them
  positions["min"] = {low.x, low.y, low.z};
  positions["max"] = {high.x, high.y, high.z};
  attributes["POSITION"] = add_array(head, 12 * mesh.vertices, kArrayBuffer, positions);
  if (mesh.has_normals) {
    attributes["NORMAL"] =
        add_array(head, 12 * mesh.vertices, kArrayBuffer, accessor(kFloat, "VEC3", mesh.vertices));
  }
  if (mesh.has_colours) {
    // Four channels: each vertex has to begin at a multiple of four bytes.
    Json colours = accessor(kUnsignedByte, "VEC4", mesh.vertices);
    colours["normalized"] = true;
    attributes["COLOR_0"] = add_array(head, 4 * mesh.vertices, kArrayBuffer, colours);
  }
  const size_t indices = add_array(head, 12 * mesh.triangles, kElementArrayBuffer,
                                   accessor(kUnsignedInt, "SCALAR", 3 * mesh.triangles));
  // Not metallic, else a map looks like dark metal.
  head["materials"].push_back({{"pbrMetallicRoughness", {{"metallicFactor", 0}, {"roughnessFactor", 1}}}});
  Json& primitive = head["meshes"][0]["primitives"][0];
  primitive = {{"attributes", attributes}, {"indices", indices}, {"material", 0}, {"mode", kTriangles}};
  head["nodes"].push_back({{"name", "map"}, {"mesh", 0}, {"rotation", {1, 0, 0, 0}}});  // x y z w
  head["scenes"][0]["nodes"].push_back(0);
}

void put_body(const MeshStream& mesh, ByteBlocks& out) {
  mesh.for_each_vertices([&](const Mesh& block) {
    for (const Vec3f p : block.vertices) out.put(p);
  });
  mesh.for_each_vertices([&](const Mesh& block) {
    for (const Vec3f n : block.normals) out.put(n);
  });
  const std::array<uint8_t, 256> linear = linear_of_srgb();
  mesh.for_each_vertices([&](const Mesh& block) {
    for (const Rgb8 c : block.colours) out.put(Rgba8{linear[c.r], linear[c.g], linear[c.b], 255});
  });
  mesh.for_each_triangles([&](std::span<const std::array<uint32_t, 3>> block) {
    for (const auto& triangle : block) out.put(triangle);
  });
}

}  // namespace

void write_glb(const MeshStream& mesh, const ByteSink& sink) {
  const uint64_t body_bytes =
      mesh.vertices * (12 + (mesh.has_normals ? 12 : 0) + (mesh.has_colours ? 4 : 0)) + mesh.triangles * 12;
  constexpr uint64_t kRoomForJson = 1 << 16;
  if (body_bytes > std::numeric_limits<uint32_t>::max() - kRoomForJson) {
    throw Error("the map has " + std::to_string(body_bytes >> 20) +
                " MiB, and a .glb file holds at most 4096: write it as .ply, or simplify it");
  }
  const bool has_mesh = mesh.triangles > 0;
  Json head = {
      {"asset", {{"version", "2.0"}, {"generator", "Kintsugi"}}}, {"scene", 0}, {"scenes", Json::array()}};
  head["scenes"].push_back(Json::object());
  if (has_mesh) add_mesh(head, mesh, body_bytes);
  std::string text = head.dump();
  text.resize((text.size() + 3) / 4 * 4, ' ');

  ByteBlocks out(sink);
  const auto put_words = [&](std::initializer_list<uint64_t> words) {
    for (const uint64_t word : words) out.put(static_cast<uint32_t>(word));
  };
  constexpr uint64_t kFileHead = 12, kChunkHead = 8;
  put_words(
      {kMagic, kVersion, kFileHead + kChunkHead + text.size() + (has_mesh ? kChunkHead + body_bytes : 0)});
  put_words({text.size(), kJsonChunk});
  out.text(text);
  if (has_mesh) {
    put_words({body_bytes, kBinaryChunk});
    put_body(mesh, out);
  }
  out.flush();
}

std::string glb_bytes(const Mesh& mesh) {
  return gathered_bytes([&](const ByteSink& sink) { write_glb(stream_of(mesh), sink); });
}

}  // namespace kt
