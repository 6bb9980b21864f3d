// Drops the small loose pieces of a map in tiles.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "offboard/map/tile_file.h"

namespace kt {

/// An island is what hangs together through common vertices. One smaller than either limit falls; 0 asks for
/// nothing.
struct IslandConfig {
  int64_t min_triangles = 30;
  double min_area_m2 = 0.001;  ///< a square of some 3 cm
};

struct IslandReport {
  int64_t islands = 0;  ///< before
  int64_t dropped_islands = 0;
  int64_t dropped_triangles = 0;
};

/// Knows which islands of a tile file fall. In memory are one tile, and 20 bytes for each piece of a tile
/// that its border cuts off from the rest of its island. Which fall does not depend on the tiles, but for the
/// rounding of areas.
class IslandSieve {
 public:
  /// Reads all tiles once. `scratch`: a file, removed again. Throws kt::Error for a damaged tile or a full
  /// disk.
  IslandSieve(const IslandConfig& config, const TileFile& tiles, const std::filesystem::path& scratch);

  /// By triangle of a tile of the file: whether its island stands.
  std::vector<bool> standing(size_t place, const MeshTile& tile) const;
  const IslandReport& report() const { return report_; }

 private:
  struct Island {
    int64_t triangles = 0;
    double area_m2 = 0;
  };
  struct Pieces;
  Pieces pieces_of(const WeldedMesh& mesh) const;
  bool is_small(const Island& island) const;
  void count(const Island& island);

  IslandConfig config_;
  TileGrid grid_;
  std::vector<uint32_t> first_;   // by tile: the number of its first cut piece
  std::vector<uint32_t> parent_;  // of cut pieces, as sets, each named by its smallest member
  std::vector<Island> islands_;   // by the name of the set
  IslandReport report_;
};

}  // namespace kt
