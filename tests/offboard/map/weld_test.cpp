// Welding: slices of one surface join without gap, copies that differ are averaged, and order does not
// matter.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/map/weld.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <map>

#include "shared/core/check.h"
#include "shared/io/mesh_stream.h"
#include "tests/offboard/map/made_slices.h"

namespace kt {
namespace {

constexpr double kVoxel_m = 0.01;

// A height field over the cells [x0, x1) x [0, height): one vertex per column, on the column's z edge.
CloudSlice height_field(int x0, int x1, int height) {
  CloudSlice slice;
  slice.voxel_size_m = kVoxel_m;
  for (int y = 0; y <= height; ++y) {
    for (int x = x0; x <= x1; ++x) {
      const float z = 0.005f * std::sin(0.3f * static_cast<float>(x)) + 0.001f * static_cast<float>(y % 3);
      slice.vertices.push_back({EdgeKey::of({x, y, -5}, 2),
                                {0.01f * static_cast<float>(x), 0.01f * static_cast<float>(y), z},
                                {0, 0, 1},
                                {100, 150, 200},
                                3,
                                0});
    }
  }
  const auto row = static_cast<uint32_t>(x1 - x0 + 1);
  for (uint32_t y = 0; y < static_cast<uint32_t>(height); ++y) {
    for (uint32_t x = 0; x + 1 < row; ++x) {
      const uint32_t a = y * row + x, b = a + 1, c = a + row, d = c + 1;
      slice.triangles.push_back({a, b, d});
      slice.triangles.push_back({a, d, c});
    }
  }
  return slice;
}

bool same(const Mesh& a, const Mesh& b) {
  return mesh_digest(stream_of(a)).value() == mesh_digest(stream_of(b)).value();
}

// Edges that belong to one triangle only, and those of more than two.
std::pair<int, int> open_and_crowded_edges(const Mesh& mesh) {
  std::map<std::pair<uint32_t, uint32_t>, int> count;
  for (const auto& t : mesh.triangles) {
    for (int i = 0; i < 3; ++i)
      ++count[std::minmax(t[static_cast<size_t>(i)], t[static_cast<size_t>((i + 1) % 3)])];
  }
  int open = 0, crowded = 0;
  for (const auto& [edge, n] : count) open += n == 1, crowded += n > 2;
  return {open, crowded};
}

TEST(Weld, PartsOfASliceBecomeTheSlice) {
  const CloudSlice whole = height_field(-4, 12, 9);
  for (const size_t max_triangles : {1u, 7u, 100u, 1000u}) {
    const std::vector<CloudSlice> parts = split_slice(whole, max_triangles);
    EXPECT_EQ(parts.size(), (whole.triangles.size() + max_triangles - 1) / max_triangles);
    EXPECT_TRUE(same(weld(parts), weld({{whole}}))) << max_triangles;
  }
}

TEST(Weld, SlicesOfOneSurfaceBecomeTheWholeSurface) {
  const std::vector<CloudSlice> parts = {height_field(-4, 3, 9), height_field(3, 5, 9),
                                         height_field(5, 12, 9)};
  const std::vector<CloudSlice> whole = {height_field(-4, 12, 9)};
  const Mesh joined = weld(parts), expected = weld(whole);
  EXPECT_EQ(expected.vertices.size(), 17u * 10u);
  EXPECT_EQ(expected.triangles.size(), 16u * 9u * 2u);
  EXPECT_TRUE(same(joined, expected));
  EXPECT_EQ(open_and_crowded_edges(joined), std::make_pair(2 * (16 + 9), 0));
}

TEST(Weld, OrderOfSlicesDoesNotMatterWhereTheyAgree) {
  std::vector<CloudSlice> parts = {height_field(-4, 3, 9), height_field(3, 5, 9), height_field(5, 12, 9)};
  const Mesh mesh = weld(parts);
  std::reverse(parts.begin(), parts.end());
  EXPECT_TRUE(same(weld(parts), mesh));
}

TEST(Weld, TrianglesKeepTheirSideAndComeSorted) {
  const std::vector<CloudSlice> parts = {height_field(3, 8, 4), height_field(0, 3, 4)};
  const Mesh mesh = weld(parts);
  EXPECT_TRUE(std::is_sorted(mesh.triangles.begin(), mesh.triangles.end()));
  for (const auto& [a, b, c] : mesh.triangles) {
    EXPECT_TRUE(a < b && a < c);
    const Vec3f normal = cross(mesh.vertices[b] - mesh.vertices[a], mesh.vertices[c] - mesh.vertices[a]);
    EXPECT_GT(normal.z, 0);
  }
}

TEST(Weld, OverlappingSlicesGiveEachTriangleOnce) {
  const std::vector<CloudSlice> parts = {height_field(0, 8, 4), height_field(4, 12, 4)};
  const std::vector<CloudSlice> whole = {height_field(0, 12, 4)};
  EXPECT_TRUE(same(weld(parts), weld(whole)));
}

// A triangle whose first vertex is as given; the others are the same in all.
CloudSlice one_vertex(Vec3f p_odom, Vec3f n_odom, Rgb8 colour, float weight) {
  CloudSlice slice;
  slice.voxel_size_m = kVoxel_m;
  slice.vertices = {{EdgeKey::of({1, 2, -3}, 0), p_odom, n_odom, colour, weight, 0},
                    {EdgeKey::of({1, 2, -3}, 1), {2, 0, 0}, {1, 0, 0}, {}, 1, 0},
                    {EdgeKey::of({1, 2, -3}, 2), {3, 0, 0}, {1, 0, 0}, {}, 1, 0}};
  slice.triangles = {{0, 1, 2}};
  return slice;
}

TEST(Weld, FirstCopyStandsWhereAllAgree) {
  const std::vector<CloudSlice> slices = {one_vertex({1, 0, 0}, {1, 0, 0}, {10, 20, 30}, 5),
                                          one_vertex({1.00005f, 0, 0}, {0, 1, 0}, {200, 200, 200}, 50)};
  const Mesh mesh = weld(slices);
  ASSERT_EQ(mesh.vertices.size(), 3u);
  EXPECT_EQ(mesh.vertices[0].x, 1.0f);
  EXPECT_EQ(mesh.normals[0].x, 1.0f);
  EXPECT_EQ(mesh.colours[0], (Rgb8{10, 20, 30}));
  EXPECT_EQ(mesh.quality[0], 5.0f);
}

TEST(Weld, CopiesThatDifferAreAveragedByWeight) {
  const std::vector<CloudSlice> slices = {one_vertex({1, 0, 0}, {1, 0, 0}, {10, 20, 30}, 1),
                                          one_vertex({1.004f, 0, 0}, {0, 1, 0}, {50, 60, 75}, 3)};
  const Mesh mesh = weld(slices);
  ASSERT_EQ(mesh.vertices.size(), 3u);
  EXPECT_FLOAT_EQ(mesh.vertices[0].x, 1.003f);
  EXPECT_FLOAT_EQ(mesh.normals[0].x, 1 / std::sqrt(10.0f));
  EXPECT_FLOAT_EQ(mesh.normals[0].y, 3 / std::sqrt(10.0f));
  EXPECT_EQ(mesh.colours[0], (Rgb8{40, 50, 64}));  // 63.75 rounded
  EXPECT_EQ(mesh.quality[0], 4.0f);
}

TEST(Weld, CopiesWithoutWeightAndOpposedNormalsStayFinite) {
  const std::vector<CloudSlice> slices = {one_vertex({1, 0, 0}, {1, 0, 0}, {10, 20, 30}, 0),
                                          one_vertex({1.004f, 0, 0}, {-1, 0, 0}, {10, 20, 30}, 0)};
  const Mesh mesh = weld(slices);
  EXPECT_FLOAT_EQ(mesh.vertices[0].x, 1.002f);
  EXPECT_EQ(mesh.normals[0].x, 1.0f);
  EXPECT_EQ(mesh.quality[0], 0.0f);
}

TEST(Weld, DropsTrianglesWithARepeatedCorner) {
  CloudSlice slice = height_field(0, 1, 1);
  slice.triangles.push_back({1, 1, 2});
  slice.triangles.push_back({3, 0, 3});
  const std::vector<CloudSlice> slices = {slice};
  EXPECT_EQ(weld(slices).triangles.size(), 2u);
}

TEST(Weld, LeavesOutVerticesWithoutATriangle) {
  CloudSlice slice = height_field(0, 3, 3);
  std::erase_if(slice.triangles, [](const auto& t) { return t[0] == 0 || t[2] == 0; });  // all of vertex 0
  const Mesh mesh = weld({{slice}});
  EXPECT_EQ(mesh.vertices.size(), slice.vertices.size() - 1);
  EXPECT_EQ(mesh.normals.size(), mesh.vertices.size());
  EXPECT_EQ(mesh.colours.size(), mesh.vertices.size());
  EXPECT_EQ(mesh.quality.size(), mesh.vertices.size());
  EXPECT_EQ(mesh.vertices.front().x, slice.vertices[1].p_odom.x);
  std::vector<bool> is_used(mesh.vertices.size());
  for (const auto& t : mesh.triangles) {
    for (const uint32_t corner : t) is_used.at(corner) = true;
  }
  EXPECT_EQ(std::count(is_used.begin(), is_used.end(), false), 0);
}

// Once with a voxel more in its middle.
TEST(Weld, APlaceSeenTwiceHasOneSheet) {
  std::vector<CloudSlice> slices = {test::made_floor(0, 8, 1, {{4, 3, 0}}), test::made_floor(0, 8, 4)};
  slices[1].sequence = 1;
  const Mesh mesh = weld(slices);
  EXPECT_EQ(mesh.vertices.size(), 9u * 7u);
  EXPECT_EQ(mesh.triangles.size(), 8u * 6u * 2u);
  EXPECT_EQ(open_and_crowded_edges(mesh), std::make_pair(2 * (8 + 6), 0));
}

TEST(Weld, NothingGivesNothing) {
  EXPECT_TRUE(weld({}).vertices.empty());
  const std::vector<CloudSlice> slices(2);
  EXPECT_TRUE(weld(slices).triangles.empty());
}

TEST(Weld, GridsOfDifferentSizeAreABug) {
  std::vector<CloudSlice> slices = {height_field(0, 1, 1), height_field(1, 2, 1)};
  slices[1].voxel_size_m = 0.02;
  EXPECT_THROW(weld(slices), LogicError);
}

TEST(MeshDigest, SeesEveryList) {
  const std::vector<CloudSlice> slices = {height_field(0, 2, 2)};
  const Mesh mesh = weld(slices);
  std::vector<Mesh> changed(5, mesh);
  changed[0].vertices[1].y += 1e-6f;
  changed[1].normals[0].z = 0.5f;
  changed[2].colours[3].b ^= 1;
  changed[3].quality[2] = 9;
  std::swap(changed[4].triangles[0], changed[4].triangles[1]);
  for (const Mesh& other : changed) EXPECT_FALSE(same(other, mesh));
}

}  // namespace
}  // namespace kt
