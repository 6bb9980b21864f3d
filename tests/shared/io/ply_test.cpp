// PLY in every flavour, whole and damaged.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/io/ply.h"

#include <algorithm>
#include <bit>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "shared/io/file.h"
#include "tests/support/test_files.h"

namespace kt {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using Triangle = std::array<uint32_t, 3>;

Mesh square() {
  return {.vertices = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0.5f}},
          .normals = {{0, 0, 1}, {0, 0, 1}, {0, 0, 1}, {0, 0.6f, 0.8f}},
          .colours = {{1, 2, 3}, {4, 5, 6}, {7, 8, 9}, {255, 0, 128}},
          .quality = {0.5f, 1, 2, 3},
          .triangles = {{0, 1, 2}, {0, 2, 3}}};
}

void expect_equal(const Mesh& a, const Mesh& b) {
  EXPECT_EQ(ply_bytes(a), ply_bytes(b));  // every field, bit by bit
}

Mesh parse(const std::string& text) { return mesh_from_ply(as_bytes(text), "m.ply"); }
std::string error_in(const std::string& text) {
  return error_of([&] { parse(text); });
}

TEST(Ply, SurvivesARoundTrip) {
  const ScratchDir folder;
  write_ply(folder.path() / "m.ply", square());
  expect_equal(read_ply(folder.path() / "m.ply"), square());
  Mesh bare;
  bare.vertices = square().vertices;
  bare.triangles = square().triangles;
  expect_equal(parse(ply_bytes(bare)), bare);
  expect_equal(parse(ply_bytes(Mesh{})), Mesh{});
}

TEST(Ply, ReadsAscii) {
  const Mesh mesh = parse(
      "ply\r\nformat ascii 1.0\r\ncomment made by hand\r\nelement vertex 4\r\nproperty double x\r\nproperty "
      "double y\r\n"
      "property double z\r\nproperty uchar red\r\nproperty uchar green\r\nproperty uchar blue\r\nelement "
      "face 2\r\n"
      "property list uchar int vertex_index\r\nend_header\r\n0 0 0 1 2 3\r\n1 0 0 4 5 6\r\n1 1 0 7 8 9\r\n0 "
      "1 0.5 255 0 128\r\n"
      "3 0 1 2\r\n3 0 2 3");
  EXPECT_THAT(mesh.triangles, ElementsAre(Triangle{0, 1, 2}, Triangle{0, 2, 3}));
  EXPECT_THAT(mesh.colours, ElementsAre(Rgb8{1, 2, 3}, Rgb8{4, 5, 6}, Rgb8{7, 8, 9}, Rgb8{255, 0, 128}));
  EXPECT_EQ(mesh.vertices[3].z, 0.5f);
  EXPECT_TRUE(mesh.normals.empty());
}

TEST(Ply, ReadsBigEndian) {
  std::string text =
      "ply\nformat binary_big_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty "
      "float z\n"
      "property short label\nelement face 1\nproperty list int ushort vertex_indices\nend_header\n";
  const auto put = [&](auto value) {
    auto raw = std::bit_cast<std::array<char, sizeof value>>(value);
    std::reverse(raw.begin(), raw.end());
    text.append(raw.data(), raw.size());
  };
  for (int i = 0; i < 3; ++i) put(1.5f * static_cast<float>(i)), put(-2.0f), put(0.25f), put(int16_t{-7});
  put(int32_t{3}), put(uint16_t{2}), put(uint16_t{1}), put(uint16_t{0});
  const Mesh mesh = parse(text);
  EXPECT_EQ(mesh.vertices[2].x, 3.0f);
  EXPECT_EQ(mesh.vertices[2].y, -2.0f);
  EXPECT_THAT(mesh.triangles, ElementsAre(Triangle{2, 1, 0}));
}

TEST(Ply, SplitsPolygonsAndPassesOverWhatItDoesNotKnow) {
  const Mesh mesh = parse(
      "ply\nformat ascii 1.0\nelement camera 1\nproperty float f\nproperty list uchar float more\nelement "
      "face 2\n"
      "property uchar flags\nproperty list uchar uint vertex_indices\nelement vertex 5\nproperty float "
      "confidence\n"
      "property float x\nproperty float y\nproperty float z\nend_header\n525 2 1 2\n0 5 0 1 2 3 4\n0 2 0 1\n"
      "9 0 0 0\n9 1 0 0\n9 2 1 0\n9 1 2 0\n9 0 1 0\n");
  EXPECT_THAT(mesh.triangles, ElementsAre(Triangle{0, 1, 2}, Triangle{0, 2, 3}, Triangle{0, 3, 4}));
  EXPECT_EQ(mesh.vertices[2].x, 2);
}

TEST(Ply, FloatingPointColoursRunToOne) {
  const Mesh mesh = parse(
      "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float "
      "z\nproperty float red\n"
      "property float green\nproperty float blue\nend_header\n0 0 0 1.0 0.5 -1\n");
  EXPECT_THAT(mesh.colours, ElementsAre(Rgb8{255, 128, 0}));
}

TEST(Ply, EveryTruncationIsAnError) {
  const std::string whole = ply_bytes(square());
  for (size_t size = 0; size < whole.size(); ++size)
    EXPECT_NE(error_in(whole.substr(0, size)), "") << size << " bytes";
}

TEST(Ply, CountsAreNotBelieved) {
  const std::string vertex = "property float x\nproperty float y\nproperty float z\n";
  const auto header = [](const std::string& rest) {
    return "ply\nformat binary_little_endian 1.0\n" + rest + "end_header\n";
  };
  EXPECT_THAT(error_in(header("element vertex 4000000000000\n" + vertex)), HasSubstr("truncated"));
  EXPECT_THAT(error_in(header("element vertex 9223372036854775807\n" + vertex)), HasSubstr("truncated"));
  EXPECT_THAT(error_in(header("element vertex -1\n" + vertex)), HasSubstr("negative"));
  EXPECT_THAT(error_in(header("element nothing 4000000000\n")), HasSubstr("no properties"));
  EXPECT_THAT(
      error_in(header("element face 1\nproperty list uint int vertex_indices\n") + "\xff\xff\xff\xff"),
      HasSubstr("does not fit"));
  EXPECT_THAT(error_in(header("element face 1\nproperty list int int vertex_indices\n") + "\xff\xff\xff\xff"),
              HasSubstr("does not fit"));
}

TEST(Ply, NamesWhatIsWrong) {
  EXPECT_THAT(error_in("solid cube"), HasSubstr("m.ply: is not a PLY file"));
  EXPECT_THAT(error_in("ply\nformat ascii 1.0\nelement vertex 0\n"), HasSubstr("no end"));
  EXPECT_THAT(error_in("ply\nformat ebcdic 1.0\nend_header\n"), HasSubstr("line 2: unknown encoding"));
  EXPECT_THAT(error_in("ply\nelement vertex 0\nend_header\n"), HasSubstr("format line is missing"));
  EXPECT_THAT(error_in("ply\nformat ascii 1.0\nproperty float x\nend_header\n"),
              HasSubstr("before the first element"));
  EXPECT_THAT(error_in("ply\nformat ascii 1.0\nelement vertex 1\nproperty quad x\nend_header\n"),
              HasSubstr("unknown PLY type"));
  EXPECT_THAT(error_in("ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n1 "),
              HasSubstr("without x, y and z"));
  const std::string vertex =
      "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n";
  EXPECT_THAT(error_in(vertex + "end_header\n0 nan 0\n"), HasSubstr("not finite"));
  EXPECT_THAT(error_in(vertex + "end_header\n0 zero 0\n"), HasSubstr("not a number: zero"));
  for (const char* corner : {"1", "-1", "nan", "1e30"}) {
    EXPECT_THAT(error_in(vertex +
                         "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n3 0 0 " +
                         corner),
                HasSubstr("beyond the last vertex"));
  }
}

TEST(Mesh, MirroringKeepsTheOutside) {
  const Mesh mesh = mirrored_y(square());
  const auto [a, b, c] = mesh.triangles[0];
  EXPECT_GT(cross(mesh.vertices[b] - mesh.vertices[a], mesh.vertices[c] - mesh.vertices[a]).z, 0);
  EXPECT_EQ(mesh.vertices[2].y, -1);
  EXPECT_EQ(mesh.normals[3].y, -0.6f);
}

}  // namespace
}  // namespace kt
