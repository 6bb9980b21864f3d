// Tests of joining tiles: the mesh is that of the whole in memory, whatever the tiles are.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/map/mesh_of_tiles.h"

#include <gtest/gtest.h>
#include <map>

#include "tests/offboard/map/made_slices.h"
#include "tests/offboard/map/made_tiles.h"
#include "tests/support/peak_memory.h"

namespace kt::test {
namespace {

constexpr MeshConfig kWhole{{0, 0}, {}};

WeldedMesh made_ball() {
  return weld(std::vector{made_slice({-25, -25, -25}, {25, 25, 25}, 1,
                                     [](Vec3i v) { return v.x * v.x + v.y * v.y + v.z * v.z < 20 * 20; })});
}

void write(const std::filesystem::path& path, const WeldedMesh& mesh, int32_t side) {
  TileWriter writer(path, {side});
  write_cut(mesh, 0, 0, {side}, writer);
  writer.finish();
}

int open_edges(const Mesh& mesh) {
  std::map<std::pair<uint32_t, uint32_t>, int> uses;
  for (const auto& t : mesh.triangles) {
    for (size_t k = 0; k < 3; ++k) ++uses[std::minmax(t[k], t[(k + 1) % 3])];
  }
  return static_cast<int>(
      std::count_if(uses.begin(), uses.end(), [](const auto& use) { return use.second != 2; }));
}

TEST(MeshOfTiles, IsTheWholeWhateverTheTiles) {
  const WeldedMesh whole = made_ball();
  for (const int32_t side : {1 << 17, 64, 10, 3, 2}) {
    const ScratchDir folder;
    write(folder / "tiles", whole, side);
    const Mesh mesh = meshed(folder / "tiles", kWhole).mesh;
    EXPECT_EQ(mesh.vertices.size(), whole.vertices.size()) << side;
    EXPECT_TRUE(places_of(mesh) == places_of(whole)) << side;
    EXPECT_EQ(open_edges(mesh), 0) << side;
  }
}

TEST(MeshOfTiles, OfOneTileIsTheTile) {
  const ScratchDir folder;
  WeldedMesh floor = weld(std::vector{made_floor(2, 90, 3)});
  write(folder / "tiles", floor, kOneTile.side);
  const Mesh mesh = meshed(folder / "tiles", kWhole).mesh;
  EXPECT_EQ(mesh_digest(stream_of(mesh)).value(), mesh_digest(stream_of(floor)).value());
}

TEST(MeshOfTiles, EqualKeysOfPatchesAreNotJoined) {
  const ScratchDir folder;
  const WeldedMesh floor = weld(std::vector{made_floor(0, 20, 3)});
  TileWriter writer(folder / "tiles", {7});
  for (const int32_t patch : {0, 1}) write_cut(floor, patch, 0, {7}, writer);
  writer.finish();
  const Mesh mesh = meshed(folder / "tiles", kWhole).mesh;
  EXPECT_EQ(mesh.vertices.size(), 2 * floor.vertices.size());
  EXPECT_EQ(mesh.triangles.size(), 2 * floor.triangles.size());
}

TEST(MeshOfTiles, SimplifiedTilesLeaveNoGap) {
  const WeldedMesh whole = made_ball();
  for (const int32_t side : {1 << 17, 64, 20, 9}) {
    const ScratchDir folder;
    write(folder / "tiles", whole, side);
    const Mesh mesh = meshed(folder / "tiles", {{0, 0}, SimplifyConfig{.keep_share = 0.3}}).mesh;
    EXPECT_EQ(open_edges(mesh), 0) << side;
    EXPECT_LT(mesh.triangles.size(), whole.triangles.size() * (side > 10 ? 45 : 80) / 100) << side;
    EXPECT_GE(mesh.triangles.size(), whole.triangles.size() * 29 / 100) << side;
  }
}

TEST(MeshOfTiles, NothingGivesNothing) {
  const ScratchDir folder;
  write(folder / "tiles", {}, 8);
  const MadeMesh made = meshed(folder / "tiles", {});
  EXPECT_TRUE(made.mesh.vertices.empty());
  EXPECT_EQ(made.islands.islands, 0);
}

// Tiles of some 8 MB: forty of them take hardly more than four.
TEST(MeshOfTiles, HoldsFewTilesAtATime) {
  const ScratchDir folder;
  constexpr int kSide = 256;
  const auto growth_with = [&](int tiles) {
    {
      TileWriter writer(folder / "tiles", {kSide});
      for (int x = 0; x < tiles; ++x) {
        CloudSlice floor;
        for (int layer = 0; layer < 40; ++layer) {
          CloudSlice one = made_floor(x * kSide, (x + 1) * kSide, 1);
          const auto start = static_cast<uint32_t>(floor.vertices.size());
          for (SliceVertex& vertex : one.vertices) {
            const Vec3i v = vertex.key.voxel();
            vertex.key = EdgeKey::of({v.x, v.y, v.z + 5 * layer + 2}, vertex.key.axis());
            floor.vertices.push_back(vertex);
          }
          for (const auto& [a, b, c] : one.triangles)
            floor.triangles.push_back({a + start, b + start, c + start});
        }
        floor.voxel_size_m = 0.01;
        writer.add({{0, 0, 0, x}, weld(std::span(&floor, 1))});
      }
      writer.finish();
    }
    const TileFile file(folder / "tiles");
    return peak_growth_bytes([&] { mesh_of_tiles(file, {}, folder / "mesh", [](double) {}); });
  };
  growth_with(2);  // what the allocator keeps from here on is counted in both
  const auto few = growth_with(4), many = growth_with(40);
  if (!few || !many) GTEST_SKIP() << "the system does not tell the peak of memory";
  EXPECT_LT(*many, *few + (16 << 20));
  EXPECT_GT(std::filesystem::file_size(folder / "tiles"), 6 * static_cast<uintmax_t>(*few + (16 << 20)));
}

}  // namespace
}  // namespace kt::test
