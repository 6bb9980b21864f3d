// The slices of a mission, cut into tiles in a file.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <vector>

#include "offboard/map/tile_grid.h"
#include "shared/core/scratch_file.h"
#include "shared/types/cloud_slice.h"

namespace kt {

/// What all slices hold of a place, for as many places as there are: in memory are some 40 bytes for each
/// tile of each slice.
class SliceTiles {
 public:
  /// A tile holds the triangles of its cube, and of the cells no more than `margin` beside it. `scratch`: the
  /// file, removed in the end. Throws kt::Error as ScratchFile.
  SliceTiles(const TileGrid& grid, int32_t margin, std::filesystem::path scratch);

  /// Adds the next slice of a patch, of those that share a grid. Vertices without a triangle are left out.
  void add(int32_t patch, const CloudSlice& slice);

  /// Those that have triangles in their cube, ascending.
  std::vector<TileId> tiles() const;
  /// The parts of the slices that lie in a tile, in the order of adding.
  std::vector<CloudSlice> read(const TileId& id) const;

 private:
  struct Part {
    int64_t sequence = 0, vertices_at = 0, triangles_at = 0;
    uint32_t vertices = 0, triangles = 0;
  };
  struct Tile {
    bool is_owner = false;  // of a triangle in its cube
    std::vector<Part> parts;
  };
  void put(const CloudSlice& part, Tile& tile);

  TileGrid grid_;
  int32_t margin_;
  double voxel_size_m_ = 0;
  ScratchFile file_;
  std::map<TileId, Tile> tiles_;
};

}  // namespace kt
