// From tiles in a file to the mesh of the map.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>

#include "offboard/map/islands.h"
#include "offboard/map/simplify.h"
#include "offboard/map/stored_mesh.h"
#include "offboard/map/tile_file.h"

namespace kt {

struct MeshConfig {
  IslandConfig islands{};                    ///< smaller pieces of the mesh are dropped
  std::optional<SimplifyConfig> simplify{};  ///< fewer triangles, tile by tile
};

struct MapMesh {
  std::unique_ptr<StoredMesh> mesh;
  IslandReport islands;
};

/// Joins the tiles by their keys into one indexed mesh, without small islands, and simplified. Vertices and
/// triangles come in the order of the tiles; without simplification the map is the same for any tiles, but
/// for this order. Vertices that tiles share are not moved by simplifying, so that no gap opens; each tile
/// keeps its share of triangles.
///
/// One tile is held in memory at a time, with what simplify() takes for it. `scratch`: the files of the mesh
/// (StoredMesh) and one more for as long as it runs; told the share done. Throws kt::Error for a damaged
/// tile, a full disk, or 2^32 vertices and more.
MapMesh mesh_of_tiles(const TileFile& tiles, const MeshConfig& config, const std::filesystem::path& scratch,
                      const std::function<void(double)>& progress);

}  // namespace kt
