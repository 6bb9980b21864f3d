// Tests of counting where a mesh shows one surface twice.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/map/double_layers.h"

#include <algorithm>
#include <gtest/gtest.h>

#include "offboard/map/mesh_parts.h"
#include "offboard/map/sheets.h"
#include "tests/offboard/map/made_sheets.h"
#include "tests/offboard/map/made_tiles.h"

namespace kt::test {
namespace {

DoubleLayers count(const std::vector<Mesh>& sheets) { return count_double_layers(concatenated(sheets)); }

TEST(DoubleLayers, OneSheetHasNone) {
  const DoubleLayers found = count({made_sheet(0, 30, 0, 1)});
  EXPECT_EQ(found.vertices, 31 * (kRows + 1));
  EXPECT_EQ(found.doubled, 0);
  EXPECT_EQ(count_double_layers(Mesh{}).share(), 0);
}

TEST(DoubleLayers, ASheetBetweenTwoAndTenCentimetresAwayIsOne) {
  for (const float z : {0.021f, 0.05f, 0.099f, -0.05f})
    EXPECT_EQ(count({made_sheet(0, 30, 0, 1), made_sheet(0, 30, z, 1)}).share(), 1) << z;
  for (const float z : {0.0f, 0.01f, 0.019f, 0.101f})
    EXPECT_EQ(count({made_sheet(0, 30, 0, 1), made_sheet(0, 30, z, 1)}).share(), 0) << z;
}

TEST(DoubleLayers, OnlyTheVerticesBesideTheOtherSheetCount) {
  const DoubleLayers found = count({made_sheet(0, 40, 0, 1), made_sheet(20, 40, 0.05f, 1)});
  EXPECT_EQ(found.vertices, (41 + 21) * (kRows + 1));
  EXPECT_EQ(found.doubled, (21 + 21) * (kRows + 1));
}

TEST(DoubleLayers, AThinWallIsNone) {
  for (const float thickness_m : {0.005f, 0.02f, 0.04f, 0.09f})
    EXPECT_EQ(count({made_sheet(0, 30, thickness_m, 1), made_sheet(0, 30, 0, 1, false)}).doubled, 0);
}

TEST(DoubleLayers, ABoardBeforeAWallIsNoneWhereItsBackWasSeen) {
  const Mesh wall = made_sheet(0, 30, 0, 1), front = made_sheet(10, 20, 0.06f, 1);
  for (const float thickness_m : {0.01f, 0.03f})
    EXPECT_EQ(count({wall, front, made_sheet(10, 20, 0.06f - thickness_m, 1, false)}).doubled, 0);
  EXPECT_EQ(count({wall, front}).doubled, 2 * 11 * (kRows + 1));
}

TEST(DoubleLayers, ASurfaceAtAnAngleIsNone) {
  EXPECT_EQ(count({made_sheet(0, 30, 0, 1), turned(made_sheet(1, 30, 0.05f, 1), 50)}).doubled, 0);
}

TEST(DoubleLayers, DoesNotDependOnOrderOrThreads) {
  const Mesh mesh =
      concatenated(std::vector{made_sheet(0, 40, 0, 1), turned(made_sheet(5, 30, 0.03f, 1), 7)});
  const int64_t doubled = count_double_layers(mesh, 1).doubled;
  EXPECT_GT(doubled, 0);
  EXPECT_EQ(count_double_layers(mesh, 3).doubled, doubled);
  Mesh reversed = mesh;
  std::reverse(reversed.triangles.begin(), reversed.triangles.end());
  EXPECT_EQ(count_double_layers(reversed, 2).doubled, doubled);
}

TEST(DoubleLayers, OneSheetTakesThemAway) {
  const std::vector<Mesh> patches{made_sheet(0, 30, 0, 4), made_sheet(10, 40, 0.025f, 3)};
  EXPECT_GT(count(patches).share(), 0.5);
  // Left are those along the border of the better one, where both end.
  EXPECT_LE(count_double_layers(one_sheet(patches, SheetConfig{}).mesh).doubled, 2 * (kRows + 1));
}

}  // namespace
}  // namespace kt::test
