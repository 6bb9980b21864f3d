// What tiles tell later ones of the vertices that they share.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <utility>
#include <vector>

#include "offboard/map/tile_file.h"
#include "shared/core/scratch_file.h"

namespace kt {

struct BorderNumber {
  EdgeKey key;
  uint64_t number = 0;
};

/// Numbers that tiles give to the vertices on their borders, kept in a file. Tiles are gone through in the
/// order of the tile file: each sees what its neighbours before it have put.
class BorderNumbers {
 public:
  /// `tiles` has to live as long; `scratch` is removed in the end. Throws kt::Error as ScratchFile.
  BorderNumbers(const TileFile& tiles, std::filesystem::path scratch);

  /// What the earlier neighbours of a tile have put, ascending by key.
  std::vector<BorderNumber> before(size_t tile) const;
  void put(size_t tile, std::span<const BorderNumber> numbers);

 private:
  const TileFile& tiles_;
  ScratchFile file_;
  std::vector<std::pair<int64_t, size_t>> places_;  // by tile: where its numbers begin, and their count
};

}  // namespace kt
