// Files of tiles for tests, and what is made of them, in memory.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <span>
#include <vector>

#include "offboard/map/mesh_of_tiles.h"
#include "offboard/map/sheets.h"
#include "offboard/map/weld.h"
#include "tests/support/test_files.h"

namespace kt::test {

inline constexpr TileGrid kOneTile{1 << 17};  // larger than what tests make

/// A mesh with made-up keys, all in one tile and none on its border.
inline MeshTile made_tile(int32_t patch, const Mesh& mesh) {
  MeshTile tile{{patch, 0, 0, 0}, {mesh, {}}};
  for (size_t i = 0; i < mesh.vertices.size(); ++i)
    tile.mesh.keys.push_back(
        EdgeKey::of({static_cast<int32_t>(i % 1000) + 1, 1, static_cast<int32_t>(i / 1000) + 1}, 0));
  return tile;
}

/// A welded mesh, cut into tiles; each holds the triangles of its cube and of `margin` cells around it.
inline void write_cut(const WeldedMesh& mesh, int32_t patch, int32_t margin, const TileGrid& grid,
                      TileWriter& writer) {
  std::vector<TileId> ids;
  for (size_t t = 0; t < mesh.triangles.size(); ++t) ids.push_back(grid.tile_of(patch, cell_of(mesh, t)));
  std::sort(ids.begin(), ids.end());
  ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
  for (const TileId& id : ids) {
    std::vector<bool> is_within;
    for (size_t t = 0; t < mesh.triangles.size(); ++t)
      is_within.push_back(grid.is_within(id, cell_of(mesh, t), margin));
    MeshTile tile{id, mesh};
    keep_triangles(is_within, tile.mesh);
    writer.add(tile);
  }
}

inline Mesh gathered(const MeshStream& stream) {
  Mesh mesh;
  const auto append = [](auto& to, const auto& more) { to.insert(to.end(), more.begin(), more.end()); };
  stream.for_each_vertices([&](const Mesh& block) {
    append(mesh.vertices, block.vertices);
    append(mesh.normals, block.normals);
    append(mesh.colours, block.colours);
    append(mesh.quality, block.quality);
  });
  stream.for_each_triangles([&](const auto& block) { append(mesh.triangles, block); });
  return mesh;
}

struct MadeMesh {
  Mesh mesh;
  IslandReport islands;
};

/// What mesh_of_tiles makes of a file of tiles.
inline MadeMesh meshed(const std::filesystem::path& tiles, const MeshConfig& config) {
  const MapMesh made = mesh_of_tiles(TileFile(tiles), config, tiles, [](double) {});
  return {gathered(made.mesh->stream()), made.islands};
}

/// Triangles as the places of their corners, each from its least on, sorted: what does not depend on the
/// order.
inline std::vector<std::array<std::array<float, 3>, 3>> places_of(const Mesh& mesh) {
  std::vector<std::array<std::array<float, 3>, 3>> places;
  for (const auto& triangle : mesh.triangles) {
    auto& at = places.emplace_back();
    for (size_t k = 0; k < 3; ++k) {
      const Vec3f p = mesh.vertices[triangle[k]];
      at[k] = {p.x, p.y, p.z};
    }
    std::rotate(at.begin(), std::min_element(at.begin(), at.end()), at.end());
  }
  std::sort(places.begin(), places.end());
  return places;
}

struct OneSheet {
  Mesh mesh;
  int64_t dropped_triangles = 0;
};

/// One sheet of patches that are one tile each.
inline OneSheet one_sheet(std::span<const Mesh> patches, const SheetConfig& config) {
  const ScratchDir folder;
  TileWriter writer(folder / "patches", kOneTile), sheet(folder / "sheet", kOneTile);
  for (size_t i = 0; i < patches.size(); ++i) writer.add(made_tile(static_cast<int32_t>(i), patches[i]));
  writer.finish();
  OneSheet one;
  one.dropped_triangles = kt::one_sheet(TileFile(folder / "patches"), config, folder / "marks", sheet);
  sheet.finish();
  one.mesh = meshed(folder / "sheet", {{0, 0}, {}}).mesh;
  return one;
}

}  // namespace kt::test
