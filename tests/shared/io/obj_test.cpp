// OBJ text, read back by a small reader of its own.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/io/obj.h"

#include <cmath>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sstream>

#include "shared/io/ply.h"
#include "tests/shared/io/made_mesh.h"

namespace kt {
namespace {

using ::testing::HasSubstr;

// Knows what the writer writes; fails on anything else.
Mesh read_obj(const std::string& text) {
  Mesh mesh;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string kind;
    words >> kind;
    Vec3f v;
    if (kind == "v") {
      EXPECT_TRUE(words >> v.x >> v.y >> v.z) << line;
      mesh.vertices.push_back(v);
      float r = 0, g = 0, b = 0;
      const auto byte = [](float c) { return static_cast<uint8_t>(std::lround(c * 255)); };
      if (words >> r >> g >> b) mesh.colours.push_back({byte(r), byte(g), byte(b)});
    } else if (kind == "vn") {
      EXPECT_TRUE(words >> v.x >> v.y >> v.z) << line;
      mesh.normals.push_back(v);
    } else if (kind == "f") {
      auto& triangle = mesh.triangles.emplace_back();
      for (uint32_t& corner : triangle) {
        std::string word;
        EXPECT_TRUE(words >> word) << line;
        corner = static_cast<uint32_t>(std::stoul(word)) - 1;
        const std::string number = std::to_string(corner + 1);
        EXPECT_EQ(word, mesh.normals.empty() ? number : number + "//" + number);
      }
    } else {
      EXPECT_EQ(kind, "#") << line;
    }
  }
  return mesh;
}

TEST(Obj, SurvivesARoundTripWithColoursAndNormals) {
  Mesh mesh = test::made_mesh();
  const Mesh read = read_obj(obj_bytes(mesh));
  mesh.quality.clear();
  EXPECT_EQ(ply_bytes(read), ply_bytes(mesh));  // every field, bit by bit
}

TEST(Obj, LeavesOutWhatTheMeshLacks) {
  Mesh bare;
  bare.vertices = test::made_mesh().vertices;
  bare.triangles = test::made_mesh().triangles;
  EXPECT_EQ(ply_bytes(read_obj(obj_bytes(bare))), ply_bytes(bare));
  EXPECT_THAT(obj_bytes(bare), HasSubstr("\nf 1 2 3\n"));
  EXPECT_EQ(obj_bytes(Mesh{}), "# metres\n");
}

}  // namespace
}  // namespace kt
