// Tests of dropping small loose pieces.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/map/islands.h"

#include <gtest/gtest.h>

#include "offboard/map/mesh_parts.h"
#include "shared/io/ply.h"
#include "tests/offboard/map/made_sheets.h"

namespace kt::test {
namespace {

// 1200, 80 and 40 triangles of half a square centimetre.
std::vector<Mesh> three_islands() {
  return {made_sheet(0, 30, 0, 1), made_sheet(40, 42, 0, 1), made_sheet(50, 51, 0, 1)};
}

TEST(Islands, ThoseOfTooFewTrianglesFall) {
  Mesh mesh = concatenated(three_islands());
  const IslandReport report = drop_small_islands({.min_triangles = 80, .min_area_m2 = 0}, mesh);
  EXPECT_EQ(report.islands, 3);
  EXPECT_EQ(report.dropped_islands, 1);
  EXPECT_EQ(report.dropped_triangles, kPerColumn);
  const std::vector<Mesh> islands = three_islands();
  EXPECT_EQ(ply_bytes(mesh), ply_bytes(concatenated(std::span(islands).first(2))));
}

TEST(Islands, ThoseOfTooLittleAreaFall) {
  Mesh mesh = concatenated(three_islands());
  const IslandReport report = drop_small_islands({.min_triangles = 0, .min_area_m2 = 0.005}, mesh);
  EXPECT_EQ(report.dropped_islands, 2);
  EXPECT_EQ(report.dropped_triangles, 3 * kPerColumn);
  EXPECT_EQ(ply_bytes(mesh), ply_bytes(three_islands()[0]));
}

TEST(Islands, WithoutLimitsNothingFalls) {
  Mesh mesh = concatenated(three_islands());
  const IslandReport report = drop_small_islands({.min_triangles = 0, .min_area_m2 = 0}, mesh);
  EXPECT_EQ(report.islands, 3);
  EXPECT_EQ(report.dropped_islands, 0);
  EXPECT_EQ(ply_bytes(mesh), ply_bytes(concatenated(three_islands())));
}

TEST(Islands, ACommonVertexJoins) {
  Mesh mesh{.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}},
            .normals = {},
            .colours = {},
            .quality = {},
            .triangles = {{0, 1, 2}, {3, 4, 0}}};
  EXPECT_EQ(drop_small_islands({.min_triangles = 2, .min_area_m2 = 0.9}, mesh).islands, 1);
  EXPECT_EQ(mesh.triangles.size(), 2u);
}

TEST(Islands, OfNothingThereAreNone) {
  Mesh mesh;
  EXPECT_EQ(drop_small_islands({}, mesh).islands, 0);
  mesh.vertices = {{0, 0, 0}};  // and a vertex without a triangle goes
  EXPECT_EQ(drop_small_islands({}, mesh).islands, 0);
  EXPECT_TRUE(mesh.vertices.empty());
}

}  // namespace
}  // namespace kt::test
