// Tests of tiles in a file: what comes back, and that damage is told of.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/map/tile_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/offboard/map/made_slices.h"
#include "tests/offboard/map/made_tiles.h"

namespace kt::test {
namespace {

using ::testing::AllOf;
using ::testing::AnyOf;
using ::testing::HasSubstr;

void write_floor(const std::filesystem::path& path, int32_t side) {
  TileWriter writer(path, {side});
  write_cut(weld(std::vector{made_floor(-9, 9, 2)}), 3, 0, {side}, writer);
  writer.finish();
}

TEST(TileGrid, CubesMeetInTheEdgesOfTheirSides) {
  const TileGrid grid{8};
  EXPECT_EQ(grid.tile_of(1, {-1, 0, 7}), (TileId{1, 0, 0, -1}));
  EXPECT_EQ(grid.tile_of(1, {-8, 8, -9}), (TileId{1, -2, 1, -1}));
  for (const int axis : {0, 1, 2}) {
    EXPECT_FALSE(grid.is_shared(EdgeKey::of({1, 2, 3}, axis)));
    EXPECT_EQ(grid.is_shared(EdgeKey::of({-8, 2, 3}, axis)), axis != 0);
    EXPECT_EQ(grid.is_shared(EdgeKey::of({1, 2, 16}, axis)), axis != 2);
  }
  EXPECT_TRUE(grid.is_within({0, 0, 0, 0}, {-2, 9, 3}, 2));
  EXPECT_FALSE(grid.is_within({0, 0, 0, 0}, {-3, 9, 3}, 2));
  EXPECT_FALSE(grid.is_within({0, 0, 0, 0}, {0, 10, 3}, 2));
}

TEST(TileFile, GivesBackWhatItWasGiven) {
  const ScratchDir folder;
  const WeldedMesh floor = weld(std::vector{made_floor(-9, 9, 2)});
  TileWriter writer(folder / "tiles", kOneTile);
  writer.add({{2, 0, 0, 1}, floor});
  writer.add({{2, 0, 0, 0}, floor});
  writer.add({{1, 0, 0, 0}, {}});
  writer.finish();
  const TileFile file(folder / "tiles");
  EXPECT_EQ(file.grid().side, kOneTile.side);
  ASSERT_EQ(file.tiles().size(), 2u) << "one without triangles is none";
  EXPECT_EQ(file.tiles()[0].id, (TileId{2, 0, 0, 0}));
  EXPECT_FLOAT_EQ(file.tiles()[0].low.x, -0.09f);
  EXPECT_FLOAT_EQ(file.tiles()[0].high.x, 0.09f);
  EXPECT_EQ(file.find({2, 0, 0, 1}), 1u);
  EXPECT_FALSE(file.find({1, 0, 0, 0}));
  for (const size_t place : {1u, 0u}) {
    const MeshTile tile = file.read(place);
    EXPECT_EQ(tile.id, file.tiles()[place].id);
    EXPECT_EQ(tile.mesh.keys, floor.keys);
    EXPECT_EQ(mesh_digest(stream_of(tile.mesh)).value(), mesh_digest(stream_of(floor)).value());
  }
}

TEST(TileFile, DamageAnywhereIsAnErrorThatNamesTheFileAndTheRemedy) {
  const ScratchDir folder;
  write_floor(folder / "whole", 6);
  const std::vector<uint8_t> whole = read_bytes(folder / "whole");
  const auto error_with = [&](const std::vector<uint8_t>& bytes) {
    write_bytes(folder / "tiles", bytes);
    return error_of([&] { meshed(folder / "tiles", {}); });
  };
  EXPECT_EQ(error_with(whole), "");
  const auto told =
      AllOf(HasSubstr("tiles: "), AnyOf(HasSubstr("run kintsugi-map again"), HasSubstr("no file of tiles")));
  for (size_t at = 0; at < whole.size(); at += 37) {
    std::vector<uint8_t> bytes = whole;
    bytes[at] ^= 0x10;
    // Of the head the padding of the side means nothing only where it stays in range.
    EXPECT_THAT(error_with(bytes), told) << at;
  }
  for (size_t size = 0; size < whole.size(); size += 211)
    EXPECT_THAT(error_with({whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size)}), told) << size;
  EXPECT_THAT(error_of([&] { TileFile(folder / "missing"); }), HasSubstr("missing: cannot be read"));
}

TEST(TileFile, WhatIsNotFinishedIsNotThere) {
  const ScratchDir folder;
  {
    TileWriter writer(folder / "tiles", kOneTile);
    writer.add({{0, 0, 0, 0}, weld(std::vector{made_floor(0, 9, 2)})});
  }
  EXPECT_FALSE(std::filesystem::exists(folder / "tiles"));
}

}  // namespace
}  // namespace kt::test
