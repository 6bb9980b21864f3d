// Islands by union-find over the vertices, measured in the order of the triangles.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/map/islands.h"

#include <algorithm>
#include <numeric>
#include <vector>

#include "offboard/map/mesh_parts.h"

namespace kt {
namespace {

// Sets of vertices, each named by its smallest member (path halving, Tarjan and van Leeuwen 1984).
class VertexSets {
 public:
  explicit VertexSets(size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), 0u); }
  uint32_t root(uint32_t v) {
    while (parent_[v] != v) v = parent_[v] = parent_[parent_[v]];
    return v;
  }
  void join(uint32_t a, uint32_t b) {
    const uint32_t root_a = root(a), root_b = root(b);
    if (root_a != root_b) parent_[std::max(root_a, root_b)] = std::min(root_a, root_b);
  }

 private:
  std::vector<uint32_t> parent_;
};

struct Island {
  int64_t triangles = 0;
  double area_m2 = 0;
};

}  // namespace

IslandReport drop_small_islands(const IslandConfig& config, Mesh& mesh) {
  VertexSets sets(mesh.vertices.size());
  for (const auto& [a, b, c] : mesh.triangles) {
    sets.join(a, b);
    sets.join(b, c);
  }
  std::vector<Island> islands(mesh.vertices.size());  // by the smallest vertex
  for (const auto& [a, b, c] : mesh.triangles) {
    Island& island = islands[sets.root(a)];
    ++island.triangles;
    island.area_m2 += 0.5 * static_cast<double>(norm(cross(mesh.vertices[b] - mesh.vertices[a],
                                                           mesh.vertices[c] - mesh.vertices[a])));
  }
  const auto is_small = [&](const Island& island) {
    return island.triangles < config.min_triangles || island.area_m2 < config.min_area_m2;
  };
  IslandReport report;
  for (const Island& island : islands) {
    if (island.triangles == 0) continue;
    ++report.islands;
    if (!is_small(island)) continue;
    ++report.dropped_islands;
    report.dropped_triangles += island.triangles;
  }
  std::vector<bool> stands(mesh.triangles.size());
  for (size_t t = 0; t < stands.size(); ++t) stands[t] = !is_small(islands[sets.root(mesh.triangles[t][0])]);
  keep_triangles(stands, mesh);
  return report;
}

}  // namespace kt
