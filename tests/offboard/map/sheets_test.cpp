// Tests of making one sheet of several that show the same surface.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/map/sheets.h"

#include <gtest/gtest.h>

#include "offboard/map/mesh_parts.h"
#include "shared/io/ply.h"
#include "tests/offboard/map/made_sheets.h"
#include "tests/offboard/map/made_tiles.h"

namespace kt::test {
namespace {

constexpr SheetConfig kConfig{};

// Triangles by the weight of their patch.
int64_t triangles_of(const Mesh& mesh, float weight) {
  return std::count_if(mesh.triangles.begin(), mesh.triangles.end(),
                       [&](const auto& triangle) { return mesh.quality[triangle[0]] == weight; });
}

TEST(OneSheet, OfTwoACentimetreApartTheBetterStands) {
  const Mesh light = made_sheet(0, 30, 0.01f, 3), heavy = made_sheet(0, 30, 0, 4);
  for (const std::vector<Mesh>& patches : {std::vector{light, heavy}, {heavy, light}}) {
    const OneSheet one = one_sheet(patches, kConfig);
    EXPECT_EQ(ply_bytes(one.mesh), ply_bytes(heavy));
    EXPECT_EQ(one.dropped_triangles, 30 * kPerColumn);
  }
}

TEST(OneSheet, TheLaterOfEqualsStands) {
  const Mesh first = made_sheet(0, 30, 0, 3), second = made_sheet(0, 30, 0.01f, 3),
             third = made_sheet(0, 30, 0.02f, 3);
  EXPECT_EQ(ply_bytes(one_sheet(std::vector{first, second, third}, kConfig).mesh), ply_bytes(third));
}

TEST(OneSheet, BothSidesOfAThinWallStand) {
  for (const float thickness_m : {0.005f, 0.01f, 0.02f, 0.04f}) {
    const std::vector<Mesh> sides{made_sheet(0, 30, thickness_m, 3), made_sheet(0, 30, 0, 4, false)};
    const OneSheet one = one_sheet(sides, kConfig);
    EXPECT_EQ(one.dropped_triangles, 0);
    EXPECT_EQ(ply_bytes(one.mesh), ply_bytes(concatenated(sides)));
  }
}

TEST(OneSheet, WhatIsFartherThanTheDistanceOrTurnedFartherThanTheAngleStands) {
  const Mesh sheet = made_sheet(0, 30, 0, 4);
  EXPECT_EQ(one_sheet(std::vector{sheet, made_sheet(0, 30, 0.031f, 3)}, kConfig).dropped_triangles, 0);
  EXPECT_EQ(one_sheet(std::vector{sheet, turned(made_sheet(0, 2, 0, 3), 50)}, kConfig).dropped_triangles, 0);
  EXPECT_EQ(one_sheet(std::vector{made_sheet(-30, 30, 0, 4), turned(made_sheet(0, 2, 0, 3), 40)}, kConfig)
                .dropped_triangles,
            2 * kPerColumn);
}

// A surface that two patches see half of each, with a strip in common.
TEST(OneSheet, NoHoleOpensAndTheOverlapIsOneTriangleWide) {
  for (const float gap_m : {0.0f, 0.007f, 0.029f}) {
    const OneSheet one =
        one_sheet(std::vector{made_sheet(0, 20, 0, 4), made_sheet(10, 30, gap_m, 3)}, kConfig);
    EXPECT_EQ(triangles_of(one.mesh, 4), 20 * kPerColumn);
    // Vertices of the column x = 20 lie on the border of the better patch: covered, by the margin of a
    // triangle.
    EXPECT_EQ(triangles_of(one.mesh, 3), 10 * kPerColumn);
    for (double x = 0.0013; x < 0.3; x += 0.0031) {
      for (double y = 0.0017; y < 0.2; y += 0.0137) EXPECT_EQ(layers_at(one.mesh, x, y), 1) << x << " " << y;
    }
  }
}

TEST(OneSheet, BesideTheBorderOfTheBetterOneNothingFalls) {
  // The worse patch begins half a cell before the end of the better one: no triangle of it is covered whole.
  Mesh worse = made_sheet(20, 30, 0.01f, 3);
  for (Vec3f& p : worse.vertices) p.x -= 0.005f;
  const OneSheet one = one_sheet(std::vector{made_sheet(0, 20, 0, 4), worse}, kConfig);
  EXPECT_EQ(one.dropped_triangles, 0);
}

TEST(OneSheet, AHoleInTheBetterOneIsFilledByTheWorse) {
  Mesh better = made_sheet(0, 30, 0, 4);
  std::vector<bool> stands(better.triangles.size(), true);
  for (size_t t = 0; t < stands.size(); ++t) {
    const Vec3f p = better.vertices[better.triangles[t][0]];
    stands[t] = std::abs(p.x - 0.15f) > 0.05f || std::abs(p.y - 0.1f) > 0.04f;
  }
  keep_triangles(stands, better);
  const OneSheet one = one_sheet(std::vector{better, made_sheet(0, 30, 0.013f, 3)}, kConfig);
  EXPECT_EQ(triangles_of(one.mesh, 4), static_cast<int64_t>(better.triangles.size()));
  EXPECT_LT(triangles_of(one.mesh, 3), 2 * 13 * 11);
  for (double x = 0.0013; x < 0.3; x += 0.0031) {
    for (double y = 0.0017; y < 0.2; y += 0.0137) EXPECT_GE(layers_at(one.mesh, x, y), 1) << x << " " << y;
  }
}

TEST(OneSheet, WhatHasFallenCoversNothing) {
  const Mesh best = made_sheet(0, 30, 0, 5), middle = made_sheet(0, 30, 0.02f, 4),
             worst = made_sheet(0, 30, 0.04f, 3);
  const OneSheet one = one_sheet(std::vector{worst, middle, best}, kConfig);
  EXPECT_EQ(triangles_of(one.mesh, 5), 30 * kPerColumn);
  EXPECT_EQ(triangles_of(one.mesh, 4), 0);
  EXPECT_EQ(triangles_of(one.mesh, 3), 30 * kPerColumn);
}

// As welded maps are: uneven by noise, and turned against each other.
TEST(OneSheet, UnevenSheetsLeaveNoSplinters) {
  const auto uneven = [](Mesh mesh, uint32_t seed) {
    for (size_t i = 0; i < mesh.vertices.size(); ++i) {
      const auto random = [&](uint32_t k) {
        const uint32_t hash = (static_cast<uint32_t>(i) * 3 + k + seed) * 2654435761u;
        return static_cast<float>(hash >> 8) / static_cast<float>(1 << 24) - 0.5f;
      };
      mesh.vertices[i] = mesh.vertices[i] + Vec3f{0.004f * random(0), 0.004f * random(1), 0.004f * random(2)};
      const Vec3f n = mesh.normals[i] + Vec3f{0.3f * random(1), 0.3f * random(2), 0};
      mesh.normals[i] = (1 / norm(n)) * n;
    }
    return mesh;
  };
  Mesh worse = turned(made_sheet(3, 27, 0.01f, 3), 2);
  const OneSheet one = one_sheet(std::vector{uneven(made_sheet(0, 30, 0, 4), 1), uneven(worse, 2)}, kConfig);
  EXPECT_EQ(triangles_of(one.mesh, 4), 30 * kPerColumn);
  // Along the two edges that both sheets have in common the worse one may look over the border of the better.
  EXPECT_LE(triangles_of(one.mesh, 3), 2 * 2 * 24);
}

TEST(OneSheet, ANormalThatAgreesLessLeavesNoSplinterAndOneThatOpposesLeavesItsTriangles) {
  const Mesh better = made_sheet(0, 30, 0, 4);
  Mesh worse = made_sheet(0, 30, 0.01f, 3);
  const size_t middle = 15 * (kRows + 1) + 10;
  worse.normals[middle] = {0.8f, 0, 0.6f};  // 53 degrees
  EXPECT_EQ(ply_bytes(one_sheet(std::vector{better, worse}, kConfig).mesh), ply_bytes(better));
  worse.normals[middle] = {0, 0, -1};
  EXPECT_EQ(triangles_of(one_sheet(std::vector{better, worse}, kConfig).mesh, 3), 6);
}

TEST(OneSheet, DoesNotDependOnThreadsNorOnTheOrderOfPatchesOfDifferentWeight) {
  const std::vector<Mesh> patches{made_sheet(0, 20, 0, 4), made_sheet(10, 30, 0.012f, 3),
                                  made_sheet(5, 40, -0.011f, 2)};
  const OneSheet one = one_sheet(patches, {0.03, 45, 1});
  for (const int threads : {2, 3})
    EXPECT_EQ(ply_bytes(one_sheet(patches, {0.03, 45, threads}).mesh), ply_bytes(one.mesh));
  const OneSheet other = one_sheet(std::vector{patches[2], patches[0], patches[1]}, kConfig);
  EXPECT_EQ(other.dropped_triangles, one.dropped_triangles);
  for (const float weight : {2.0f, 3.0f, 4.0f})
    EXPECT_EQ(triangles_of(other.mesh, weight), triangles_of(one.mesh, weight));
}

TEST(OneSheet, OfOnePatchOrNoneIsWhatItWas) {
  EXPECT_EQ(ply_bytes(one_sheet(std::vector{made_sheet(0, 3, 0, 1)}, kConfig).mesh),
            ply_bytes(made_sheet(0, 3, 0, 1)));
  EXPECT_TRUE(one_sheet({}, kConfig).mesh.vertices.empty());
  EXPECT_EQ(ply_bytes(one_sheet(std::vector{Mesh{}, made_sheet(0, 3, 0, 1)}, kConfig).mesh),
            ply_bytes(made_sheet(0, 3, 0, 1)));
}

TEST(SheetConfig, IsTwoVoxelsOrThreeCentimetres) {
  EXPECT_EQ(SheetConfig::of_voxels(0.01).distance_m, 0.03);
  EXPECT_EQ(SheetConfig::of_voxels(0.02).distance_m, 0.04);
}

}  // namespace
}  // namespace kt::test
