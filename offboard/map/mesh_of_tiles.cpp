// Twice over the tiles: what hangs together, then what stands of it, numbered on from tile to tile.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/map/mesh_of_tiles.h"

#include <algorithm>
#include <limits>
#include <vector>

#include "offboard/map/border_numbers.h"
#include "shared/core/check.h"

namespace kt {
namespace {

std::vector<bool> shared_vertices(const WeldedMesh& mesh, const TileGrid& grid) {
  std::vector<bool> is_shared;
  is_shared.reserve(mesh.keys.size());
  for (const EdgeKey key : mesh.keys) is_shared.push_back(grid.is_shared(key));
  return is_shared;
}

// Appends a tile: vertices that an earlier one has put are that one's.
void append(WeldedMesh& mesh, const std::vector<bool>& is_shared, size_t place, BorderNumbers& borders,
            StoredMesh& map) {
  const std::vector<BorderNumber> before = borders.before(place);
  std::vector<BorderNumber> own;
  std::vector<uint32_t> number(mesh.vertices.size());
  std::vector<bool> is_new(mesh.vertices.size(), true);
  uint64_t next = map.vertices();
  if (next + number.size() > std::numeric_limits<uint32_t>::max())
    throw Error("the map has 2^32 vertices or more: use a larger --voxel-size");
  for (size_t v = 0; v < number.size(); ++v) {
    if (is_shared[v]) {
      const auto found = std::lower_bound(before.begin(), before.end(), mesh.keys[v],
                                          [](const BorderNumber& b, EdgeKey key) { return b.key < key; });
      is_new[v] = found == before.end() || found->key != mesh.keys[v];
      if (!is_new[v]) number[v] = static_cast<uint32_t>(found->number);
    }
    if (is_new[v]) number[v] = static_cast<uint32_t>(next++);
    if (is_shared[v]) own.push_back({mesh.keys[v], number[v]});
  }
  borders.put(place, own);
  for (auto& triangle : mesh.triangles) {
    for (uint32_t& corner : triangle) corner = number[corner];
  }
  map.add_triangles(mesh.triangles);
  keep_values(is_new, mesh.vertices);
  keep_values(is_new, mesh.normals);
  keep_values(is_new, mesh.colours);
  keep_values(is_new, mesh.quality);
  map.add_vertices(mesh);
}

}  // namespace

MapMesh mesh_of_tiles(const TileFile& tiles, const MeshConfig& config, const std::filesystem::path& scratch,
                      const std::function<void(double)>& progress) {
  std::filesystem::path borders_file = scratch;
  borders_file += ".borders";
  const IslandSieve sieve(config.islands, tiles, borders_file);
  MapMesh map{std::make_unique<StoredMesh>(scratch), sieve.report()};
  BorderNumbers borders(tiles, borders_file);
  const size_t count = tiles.tiles().size();
  for (size_t place = 0; place < count; ++place) {
    MeshTile tile = tiles.read(place);
    keep_triangles(sieve.standing(place, tile), tile.mesh);
    std::vector<bool> is_shared = shared_vertices(tile.mesh, tiles.grid());
    if (config.simplify) {
      const std::vector<bool> is_kept = simplify(*config.simplify, tile.mesh, is_shared).is_vertex_kept;
      keep_values(is_kept, tile.mesh.keys);
      is_shared = shared_vertices(tile.mesh, tiles.grid());
    }
    append(tile.mesh, is_shared, place, borders, *map.mesh);
    progress(static_cast<double>(place + 1) / static_cast<double>(count));
  }
  return map;
}

}  // namespace kt
