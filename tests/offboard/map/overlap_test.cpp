// Tests of which triangles stand where slices overlap.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/map/overlap.h"

#include <algorithm>
#include <gtest/gtest.h>
#include <numeric>

#include "tests/offboard/map/made_slices.h"

namespace kt::test {
namespace {

bool has_edge(Vec3i cell, EdgeKey key) {
  for (int edge = 0; edge < 12; ++edge) {
    if (key == EdgeKey::of(cell + MarchingCubesTable::edge_start(edge), MarchingCubesTable::edge_axis(edge)))
      return true;
  }
  return false;
}

TEST(OwningCell, IsTheOnlyOneWithAllEdgesForEveryTriangleOfMarchingCubes) {
  const MarchingCubesTable table = make_marching_cubes_table();
  int triangles = 0;
  for (const Vec3i cell :
       {Vec3i{0, 0, 0}, Vec3i{-7, 12, -1}, Vec3i{-EdgeKey::kLimit, 0, EdgeKey::kLimit - 2}}) {
    for (int pattern = 0; pattern < 256; ++pattern) {
      for (int t = 0; t < table.triangle_count[pattern]; ++t, ++triangles) {
        std::array<EdgeKey, 3> keys;
        for (size_t k = 0; k < 3; ++k) {
          const int edge = table.edges[pattern][3 * t + static_cast<int>(k)];
          keys[k] =
              EdgeKey::of(cell + MarchingCubesTable::edge_start(edge), MarchingCubesTable::edge_axis(edge));
        }
        const Vec3i found = owning_cell(keys);
        EXPECT_TRUE(found.x == cell.x && found.y == cell.y && found.z == cell.z) << pattern;
        int owners = 0;
        for (int n = 0; n < 27; ++n) {
          const Vec3i other = cell + Vec3i{n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1};
          owners += std::all_of(keys.begin(), keys.end(), [&](EdgeKey key) { return has_edge(other, key); });
        }
        EXPECT_EQ(owners, 1) << pattern;
      }
    }
  }
  EXPECT_EQ(triangles, 3 * 820);
}

std::vector<int64_t> standing(const StandingTriangles& stands) {
  std::vector<int64_t> counts;
  for (const auto& slice : stands) counts.push_back(std::count(slice.begin(), slice.end(), true));
  return counts;
}

std::vector<int64_t> chosen(const std::vector<CloudSlice>& slices) {
  return standing(one_slice_per_cell(slices, weights_of(slices)));
}

// What stands after both steps, welded vertices found by comparing keys.
std::vector<int64_t> without_splinters(const std::vector<CloudSlice>& slices) {
  std::vector<EdgeKey> keys;
  for (const CloudSlice& slice : slices) {
    for (const SliceVertex& vertex : slice.vertices) keys.push_back(vertex.key);
  }
  std::vector<uint32_t> index_of;
  for (const EdgeKey key : keys)
    index_of.push_back(static_cast<uint32_t>(std::find(keys.begin(), keys.end(), key) - keys.begin()));
  StandingTriangles stands = one_slice_per_cell(slices, weights_of(slices));
  drop_splinters(slices, index_of, stands);
  return standing(stands);
}

using Counts = std::vector<int64_t>;
constexpr int kColumn = 6 * 2;  // triangles of a floor per cell along x

TEST(OneSlicePerCell, TheGreaterMeanWeightTakesTheCellsInCommon) {
  const CloudSlice light = made_floor(0, 8, 3), heavy = made_floor(5, 12, 4);
  EXPECT_EQ(chosen(in_sequence({light, heavy})), (Counts{5 * kColumn, 7 * kColumn}));
  EXPECT_EQ(chosen(in_sequence({heavy, light})), (Counts{7 * kColumn, 5 * kColumn}));
}

TEST(OneSlicePerCell, TheLaterOfEqualsTakesTheCell) {
  EXPECT_EQ(chosen(in_sequence({made_floor(0, 8, 3), made_floor(5, 12, 3), made_floor(6, 7, 3)})),
            (Counts{5 * kColumn, 6 * kColumn, kColumn}));
}

TEST(OneSlicePerCell, PartsOfASliceAreOne) {
  const std::vector<CloudSlice> slices = in_sequence({made_floor(0, 8, 3), made_floor(5, 12, 4)});
  std::vector<CloudSlice> parts = split_slice(slices[0], 5);  // cuts through cells
  for (CloudSlice& part : split_slice(slices[1], 7)) parts.push_back(std::move(part));
  const Counts counts = chosen(parts);
  const auto second = counts.begin() + (8 * kColumn + 4) / 5;
  EXPECT_EQ(std::accumulate(counts.begin(), second, int64_t{0}), 5 * kColumn);
  EXPECT_EQ(std::accumulate(second, counts.end(), int64_t{0}), 7 * kColumn);
}

TEST(OneSlicePerCell, SlicesApartStandWhole) {
  EXPECT_EQ(
      without_splinters(in_sequence({made_floor(0, 8, 3), made_floor(8, 12, 4), made_floor(20, 22, 9)})),
      (Counts{8 * kColumn, 4 * kColumn, 2 * kColumn}));
}

TEST(OneSlicePerCell, NothingGivesNothing) {
  EXPECT_TRUE(one_slice_per_cell({}, {}).empty());
  EXPECT_EQ(without_splinters(std::vector<CloudSlice>(2)), (Counts{0, 0}));
}

TEST(DropSplinters, ASurfaceThatTheLoserPlacesInTheNextCellGoes) {
  const CloudSlice winner = made_floor(0, 10, 4);
  for (const std::vector<Vec3i>& raised :
       std::vector<std::vector<Vec3i>>{{{4, 3, 0}},
                                       {{4, 3, 0}, {5, 3, 0}},
                                       {{4, 3, 0}, {5, 4, 0}, {7, 2, 0}},
                                       {{8, 2, 0}, {8, 3, 0}, {8, 4, 0}}}) {
    const CloudSlice loser = made_floor(0, 10, 1, raised);
    EXPECT_GT(chosen(in_sequence({loser, winner}))[0], 0);
    EXPECT_EQ(without_splinters(in_sequence({loser, winner})), (Counts{0, 10 * kColumn}));
    EXPECT_EQ(without_splinters(in_sequence({winner, loser})), (Counts{10 * kColumn, 0}));
  }
}

TEST(DropSplinters, WhatGoesOnBeyondTheWinnerStays) {
  EXPECT_EQ(without_splinters(in_sequence({made_floor(0, 8, 1), made_floor(3, 8, 4)})),
            (Counts{3 * kColumn, 5 * kColumn}));
}

TEST(DropSplinters, AnOddSurfaceOfOneSliceAloneStays) {
  const CloudSlice slice = made_floor(0, 8, 1, {{4, 3, 0}});
  EXPECT_EQ(without_splinters({slice}), (Counts{static_cast<int64_t>(slice.triangles.size())}));
}

}  // namespace
}  // namespace kt::test
