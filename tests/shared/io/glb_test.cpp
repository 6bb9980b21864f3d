// Binary glTF, taken apart by hand as its specification says.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/io/glb.h"

#include <cmath>
#include <cstring>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/shared/io/made_mesh.h"

namespace kt {
namespace {

using nlohmann::json;

uint32_t word_at(const std::string& file, size_t at) {
  uint32_t word = 0;
  std::memcpy(&word, file.data() + at, sizeof word);
  return word;
}

// The two chunks of a file.
struct Chunks {
  json head;
  std::string body;
};

Chunks take_apart(const std::string& file) {
  EXPECT_EQ(file.substr(0, 4), "glTF");
  EXPECT_EQ(word_at(file, 4), 2u);
  EXPECT_EQ(word_at(file, 8), file.size());
  const uint32_t json_size = word_at(file, 12);
  EXPECT_EQ(json_size % 4, 0u);
  EXPECT_EQ(file.substr(16, 4), "JSON");
  Chunks chunks{json::parse(file.substr(20, json_size)), {}};
  const size_t body = 20 + json_size;
  if (body == file.size()) return chunks;
  EXPECT_EQ(word_at(file, body) % 4, 0u);
  EXPECT_EQ(word_at(file, body) + body + 8, file.size());
  EXPECT_EQ(file.substr(body + 4, 4), std::string("BIN\0", 4));
  chunks.body = file.substr(body + 8);
  return chunks;
}

// The values of an accessor, whose type and components must be as given.
template <typename T>
std::vector<T> values_of(const Chunks& chunks, const json& accessor_number, const std::string& type,
                         int component) {
  const json& accessor = chunks.head["accessors"][accessor_number.get<size_t>()];
  const json& view = chunks.head["bufferViews"][accessor["bufferView"].get<size_t>()];
  EXPECT_EQ(accessor["type"], type);
  EXPECT_EQ(accessor["componentType"], component);
  EXPECT_FALSE(view.contains("byteStride"));
  const size_t start = view.value("byteOffset", size_t{0}), size = view["byteLength"];
  EXPECT_EQ(start % 4, 0u);
  EXPECT_LE(start + size, chunks.body.size());
  std::vector<T> values(size / sizeof(T));
  std::memcpy(values.data(), chunks.body.data() + start, size);
  const size_t count = accessor["count"];
  EXPECT_EQ(count, type == "SCALAR" ? values.size() * sizeof(T) / 4 : values.size());
  return values;
}

constexpr int kUnsignedByte = 5121, kUnsignedInt = 5125, kFloat = 5126;

TEST(Glb, HoldsPositionsNormalsColoursAndIndices) {
  const Mesh mesh = test::made_mesh();
  const Chunks chunks = take_apart(glb_bytes(mesh));
  EXPECT_EQ(chunks.head["asset"]["version"], "2.0");
  const json& primitive = chunks.head["meshes"][0]["primitives"][0];
  EXPECT_EQ(primitive.value("mode", 4), 4);
  const auto positions = values_of<Vec3f>(chunks, primitive["attributes"]["POSITION"], "VEC3", kFloat);
  const auto normals = values_of<Vec3f>(chunks, primitive["attributes"]["NORMAL"], "VEC3", kFloat);
  const auto triangles =
      values_of<std::array<uint32_t, 3>>(chunks, primitive["indices"], "SCALAR", kUnsignedInt);
  const auto colours =
      values_of<std::array<uint8_t, 4>>(chunks, primitive["attributes"]["COLOR_0"], "VEC4", kUnsignedByte);
  ASSERT_EQ(positions.size(), mesh.vertices.size());
  ASSERT_EQ(normals.size(), mesh.normals.size());
  EXPECT_EQ(std::memcmp(positions.data(), mesh.vertices.data(), 12 * positions.size()), 0);
  EXPECT_EQ(std::memcmp(normals.data(), mesh.normals.data(), 12 * normals.size()), 0);
  EXPECT_EQ(triangles, mesh.triangles);
  EXPECT_TRUE(chunks.head["accessors"][primitive["attributes"]["COLOR_0"].get<size_t>()]["normalized"]);
  EXPECT_EQ(colours[3], (std::array<uint8_t, 4>{255, 0, 55, 255}));  // 128 of sRGB is 0.2158
  EXPECT_EQ(colours[1], (std::array<uint8_t, 4>{55, 128, 0, 255}));  // 188 is 0.5029
}

TEST(Glb, StatesTheBoundsOfPositionsAndTurnsYUp) {
  const Chunks chunks = take_apart(glb_bytes(test::made_mesh()));
  const json& primitive = chunks.head["meshes"][0]["primitives"][0];
  const json& positions = chunks.head["accessors"][primitive["attributes"]["POSITION"].get<size_t>()];
  EXPECT_EQ(positions["min"].get<std::vector<float>>(), (std::vector<float>{0, 0, -1e-7f}));
  EXPECT_EQ(positions["max"].get<std::vector<float>>(), (std::vector<float>{1, 1234.5f, 0.5f}));
  const size_t root = chunks.head["scenes"][0]["nodes"][0];
  EXPECT_EQ(chunks.head["nodes"][root]["rotation"].get<std::vector<double>>(),
            (std::vector<double>{1, 0, 0, 0}));
}

TEST(Glb, LeavesOutWhatTheMeshLacks) {
  Mesh bare;
  bare.vertices = test::made_mesh().vertices;
  bare.triangles = test::made_mesh().triangles;
  const json attributes = take_apart(glb_bytes(bare)).head["meshes"][0]["primitives"][0]["attributes"];
  EXPECT_EQ(attributes.size(), 1u);
  EXPECT_TRUE(attributes.contains("POSITION"));
  const Chunks nothing = take_apart(glb_bytes(Mesh{}));
  EXPECT_FALSE(nothing.head.contains("meshes"));
  EXPECT_TRUE(nothing.body.empty());
}

TEST(Glb, EqualMeshesGiveEqualBytes) {
  EXPECT_EQ(glb_bytes(test::made_mesh()), glb_bytes(test::made_mesh()));
}

}  // namespace
}  // namespace kt
