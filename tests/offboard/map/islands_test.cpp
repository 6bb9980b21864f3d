// Tests of dropping small loose pieces.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/map/islands.h"

#include <gtest/gtest.h>

#include "offboard/map/mesh_parts.h"
#include "shared/io/ply.h"
#include "tests/offboard/map/made_sheets.h"
#include "tests/offboard/map/made_slices.h"
#include "tests/offboard/map/made_tiles.h"

namespace kt::test {
namespace {

// 1200, 80 and 40 triangles of half a square centimetre.
std::vector<Mesh> three_islands() {
  return {made_sheet(0, 30, 0, 1), made_sheet(40, 42, 0, 1), made_sheet(50, 51, 0, 1)};
}

IslandReport drop_small_islands(const IslandConfig& config, Mesh& mesh) {
  const ScratchDir folder;
  TileWriter writer(folder / "tiles", kOneTile);
  writer.add(made_tile(0, mesh));
  writer.finish();
  MadeMesh made = meshed(folder / "tiles", {config, {}});
  mesh = std::move(made.mesh);
  return made.islands;
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
            .normals = std::vector<Vec3f>(5, {0, 0, 1}),
            .colours = std::vector<Rgb8>(5),
            .quality = std::vector<float>(5, 1),
            .triangles = {{0, 1, 2}, {3, 4, 0}}};
  EXPECT_EQ(drop_small_islands({.min_triangles = 2, .min_area_m2 = 0.9}, mesh).islands, 1);
  EXPECT_EQ(mesh.triangles.size(), 2u);
}

TEST(Islands, OfNothingThereAreNone) {
  Mesh mesh;
  EXPECT_EQ(drop_small_islands({}, mesh).islands, 0);
}

// A floor of 40 cells, one of 3 beside it, and one of 2 that lies in another patch with the same keys.
TEST(Islands, GoOverTheBordersOfTilesButNotOfPatches) {
  const WeldedMesh wide = weld(std::vector{made_floor(-20, 20, 1), made_floor(30, 33, 1)}),
                   small = weld(std::vector{made_floor(19, 21, 1)});
  std::vector<std::array<std::array<float, 3>, 3>> expected;
  for (const int32_t side : {1 << 17, 64, 7, 3, 2}) {
    const ScratchDir folder;
    TileWriter writer(folder / "tiles", {side});
    write_cut(wide, 0, 0, {side}, writer);
    write_cut(small, 1, 0, {side}, writer);
    writer.finish();
    const MadeMesh made = meshed(folder / "tiles", {{.min_triangles = 12 * 3, .min_area_m2 = 0}, {}});
    EXPECT_EQ(made.islands.islands, 3) << side;
    EXPECT_EQ(made.islands.dropped_islands, 1) << side;
    EXPECT_EQ(made.islands.dropped_triangles, 12 * 2) << side;
    EXPECT_EQ(made.mesh.vertices.size(), 41u * 7 + 4u * 7) << side;
    if (expected.empty()) expected = places_of(made.mesh);
    EXPECT_TRUE(places_of(made.mesh) == expected) << side;
    EXPECT_EQ(meshed(folder / "tiles", {{.min_triangles = 12 * 3 + 1, .min_area_m2 = 0}, {}})
                  .islands.dropped_islands,
              2)
        << side;
  }
}

}  // namespace
}  // namespace kt::test
