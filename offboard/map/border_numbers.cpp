// A list in the file for each tile.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/map/border_numbers.h"

#include <algorithm>
#include <optional>
#include <tuple>

namespace kt {

BorderNumbers::BorderNumbers(const TileFile& tiles, std::filesystem::path scratch)
    : tiles_(tiles),
      file_(std::move(scratch), "numbers of vertices between tiles"),
      places_(tiles.tiles().size()) {}

std::vector<BorderNumber> BorderNumbers::before(size_t tile) const {
  std::vector<BorderNumber> all;
  const TileId here = tiles_.tiles()[tile].id;
  for (int dz = -1; dz <= 0; ++dz) {
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        const TileId id{here.patch, here.z + dz, here.y + dy, here.x + dx};
        const std::optional<size_t> neighbour = id < here ? tiles_.find(id) : std::nullopt;
        if (!neighbour) continue;
        const auto [offset, count] = places_[*neighbour];
        const auto numbers = file_.values_at<BorderNumber>(offset, count);
        all.insert(all.end(), numbers.begin(), numbers.end());
      }
    }
  }
  std::sort(all.begin(), all.end(), [](const BorderNumber& a, const BorderNumber& b) {
    return std::tie(a.key, a.number) < std::tie(b.key, b.number);
  });
  return all;
}

void BorderNumbers::put(size_t tile, std::span<const BorderNumber> numbers) {
  places_[tile] = {file_.append(numbers), numbers.size()};
}

}  // namespace kt
