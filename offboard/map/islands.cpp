// Islands by union-find, first over the vertices of a tile, then over the pieces that its border cuts.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/map/islands.h"

#include <algorithm>
#include <limits>
#include <numeric>

#include "offboard/map/border_numbers.h"
#include "shared/core/check.h"

namespace kt {
namespace {

// Sets named by their smallest member; path halving (Tarjan and van Leeuwen 1984).
uint32_t root_of(std::vector<uint32_t>& parent, uint32_t v) {
  while (parent[v] != v) v = parent[v] = parent[parent[v]];
  return v;
}

void join(std::vector<uint32_t>& parent, uint32_t a, uint32_t b) {
  const uint32_t root_a = root_of(parent, a), root_b = root_of(parent, b);
  if (root_a != root_b) parent[std::max(root_a, root_b)] = std::min(root_a, root_b);
}

}  // namespace

// The parts of islands in one tile, in the order of their first vertices.
struct IslandSieve::Pieces {
  static constexpr uint32_t kWhole = std::numeric_limits<uint32_t>::max();
  std::vector<uint32_t> of_vertex;
  std::vector<Island> sizes;
  std::vector<uint32_t> cut;  // counts those that come to a border; kWhole for others
  uint32_t cut_count = 0;
};

IslandSieve::Pieces IslandSieve::pieces_of(const WeldedMesh& mesh) const {
  std::vector<uint32_t> parent(mesh.vertices.size());
  std::iota(parent.begin(), parent.end(), 0u);
  for (const auto& [a, b, c] : mesh.triangles) {
    join(parent, a, b);
    join(parent, b, c);
  }
  Pieces pieces;
  pieces.of_vertex.resize(parent.size());
  std::vector<bool> is_cut;
  for (uint32_t v = 0; v < parent.size(); ++v) {
    const uint32_t first = root_of(parent, v);
    if (first == v) is_cut.push_back(false);
    pieces.of_vertex[v] = first == v ? static_cast<uint32_t>(is_cut.size() - 1) : pieces.of_vertex[first];
    if (grid_.is_shared(mesh.keys[v])) is_cut[pieces.of_vertex[v]] = true;
  }
  for (const bool cut : is_cut) pieces.cut.push_back(cut ? pieces.cut_count++ : Pieces::kWhole);
  pieces.sizes.resize(is_cut.size());
  for (const auto& [a, b, c] : mesh.triangles) {
    Island& island = pieces.sizes[pieces.of_vertex[a]];
    ++island.triangles;
    island.area_m2 += 0.5 * static_cast<double>(norm(cross(mesh.vertices[b] - mesh.vertices[a],
                                                           mesh.vertices[c] - mesh.vertices[a])));
  }
  return pieces;
}

bool IslandSieve::is_small(const Island& island) const {
  return island.triangles < config_.min_triangles || island.area_m2 < config_.min_area_m2;
}

void IslandSieve::count(const Island& island) {
  ++report_.islands;
  if (!is_small(island)) return;
  ++report_.dropped_islands;
  report_.dropped_triangles += island.triangles;
}

IslandSieve::IslandSieve(const IslandConfig& config, const TileFile& tiles,
                         const std::filesystem::path& scratch)
    : config_(config), grid_(tiles.grid()) {
  BorderNumbers borders(tiles, scratch);
  for (size_t place = 0; place < tiles.tiles().size(); ++place) {
    const MeshTile tile = tiles.read(place);
    const Pieces pieces = pieces_of(tile.mesh);
    const auto first = static_cast<uint32_t>(parent_.size());
    KT_CHECK(parent_.size() + pieces.cut_count < Pieces::kWhole, "too many pieces");
    first_.push_back(first);
    for (size_t i = 0; i < pieces.sizes.size(); ++i) {
      if (pieces.cut[i] == Pieces::kWhole) {
        count(pieces.sizes[i]);
        continue;
      }
      parent_.push_back(static_cast<uint32_t>(parent_.size()));
      islands_.push_back(pieces.sizes[i]);
    }
    const std::vector<BorderNumber> before = borders.before(place);
    std::vector<BorderNumber> own;
    auto other = before.begin();
    for (size_t v = 0; v < tile.mesh.keys.size(); ++v) {
      const EdgeKey key = tile.mesh.keys[v];
      if (!grid_.is_shared(key)) continue;
      own.push_back({key, first + pieces.cut[pieces.of_vertex[v]]});
      while (other != before.end() && other->key < key) ++other;
      for (; other != before.end() && other->key == key; ++other)
        join(parent_, static_cast<uint32_t>(other->number), static_cast<uint32_t>(own.back().number));
    }
    borders.put(place, own);
  }
  for (uint32_t piece = 0; piece < parent_.size(); ++piece) {
    parent_[piece] = parent_[parent_[piece]];  // the names ascend: that of the parent is known
    const uint32_t name = parent_[piece];
    if (name == piece) continue;
    islands_[name].triangles += islands_[piece].triangles;
    islands_[name].area_m2 += islands_[piece].area_m2;
  }
  for (uint32_t piece = 0; piece < parent_.size(); ++piece) {
    if (parent_[piece] == piece) count(islands_[piece]);
  }
}

std::vector<bool> IslandSieve::standing(size_t place, const MeshTile& tile) const {
  const Pieces pieces = pieces_of(tile.mesh);
  std::vector<bool> stands;
  stands.reserve(tile.mesh.triangles.size());
  for (const auto& triangle : tile.mesh.triangles) {
    const uint32_t piece = pieces.of_vertex[triangle[0]], cut = pieces.cut[piece];
    stands.push_back(
        !is_small(cut == Pieces::kWhole ? pieces.sizes[piece] : islands_[parent_[first_[place] + cut]]));
  }
  return stands;
}

}  // namespace kt
