// Each slice is cut when it is added; its parts are appended to the file.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/map/slice_tiles.h"

#include <array>
#include <type_traits>
#include <utility>

namespace kt {

static_assert(std::is_trivially_copyable_v<SliceVertex>, "vertices are kept as they lie in memory");

SliceTiles::SliceTiles(const TileGrid& grid, int32_t margin, std::filesystem::path scratch)
    : grid_(grid), margin_(margin), file_(std::move(scratch), "the slices of the mission") {}

void SliceTiles::add(int32_t patch, const CloudSlice& slice) {
  voxel_size_m_ = slice.voxel_size_m;
  struct Share {
    std::vector<uint32_t> triangles;
    bool is_owner = false;
  };
  std::map<TileId, Share> shares;
  for (uint32_t t = 0; t < slice.triangles.size(); ++t) {
    const auto [a, b, c] = slice.triangles[t];
    const Vec3i cell = owning_cell({slice.vertices[a].key, slice.vertices[b].key, slice.vertices[c].key});
    const Vec3i reach{margin_, margin_, margin_};
    const TileId own = grid_.tile_of(patch, cell), low = grid_.tile_of(patch, cell - reach),
                 high = grid_.tile_of(patch, cell + reach);
    for (TileId id{patch, low.z, 0, 0}; id.z <= high.z; ++id.z) {
      for (id.y = low.y; id.y <= high.y; ++id.y) {
        for (id.x = low.x; id.x <= high.x; ++id.x) {
          Share& share = shares[id];
          share.triangles.push_back(t);
          share.is_owner |= id == own;
        }
      }
    }
  }
  for (const auto& [id, share] : shares) {
    Tile& tile = tiles_[id];
    tile.is_owner |= share.is_owner;
    put(part_of(slice, share.triangles), tile);
  }
}

void SliceTiles::put(const CloudSlice& part, Tile& tile) {
  Part& entry = tile.parts.emplace_back();
  entry.sequence = part.sequence;
  entry.vertices = static_cast<uint32_t>(part.vertices.size());
  entry.triangles = static_cast<uint32_t>(part.triangles.size());
  entry.vertices_at = file_.append(std::span(part.vertices));
  entry.triangles_at = file_.append(std::span(part.triangles));
}

std::vector<TileId> SliceTiles::tiles() const {
  std::vector<TileId> all;
  for (const auto& [id, tile] : tiles_) {
    if (tile.is_owner) all.push_back(id);
  }
  return all;
}

std::vector<CloudSlice> SliceTiles::read(const TileId& id) const {
  std::vector<CloudSlice> parts;
  for (const Part& entry : tiles_.at(id).parts) {
    CloudSlice& part = parts.emplace_back();
    part.sequence = entry.sequence;
    part.voxel_size_m = voxel_size_m_;
    part.vertices = file_.values_at<SliceVertex>(entry.vertices_at, entry.vertices);
    part.triangles = file_.values_at<std::array<uint32_t, 3>>(entry.triangles_at, entry.triangles);
  }
  return parts;
}

}  // namespace kt
