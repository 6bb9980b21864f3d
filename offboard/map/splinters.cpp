// Finds splinters by the open edges of suspects: some 70 bytes for each suspect.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/map/splinters.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace kt {
namespace {

using Triangle = std::array<uint32_t, 3>;
using MeshEdge = std::pair<uint32_t, uint32_t>;  // welded vertices, the smaller first

struct Suspect {
  size_t triangle;
  Triangle edges;  // numbers of its edges
};

std::array<MeshEdge, 3> edges_of(const Triangle& welded) {
  const auto [a, b, c] = welded;
  return {std::minmax({a, b}), std::minmax({b, c}), std::minmax({c, a})};
}

// The edges of all suspects in ascending order.
class EdgeList {
 public:
  explicit EdgeList(std::vector<MeshEdge> edges) : edges_(std::move(edges)) {
    std::sort(edges_.begin(), edges_.end());
    edges_.erase(std::unique(edges_.begin(), edges_.end()), edges_.end());
    if (edges_.empty()) return;
    is_first_.resize(edges_.back().first + size_t{1});
    for (const MeshEdge& edge : edges_) is_first_[edge.first] = true;
  }
  size_t size() const { return edges_.size(); }
  /// The number of an edge, or size() where no suspect has it.
  size_t find(const MeshEdge& edge) const {
    if (edge.first >= is_first_.size() || !is_first_[edge.first]) return size();
    const auto found = std::lower_bound(edges_.begin(), edges_.end(), edge);
    return found != edges_.end() && *found == edge ? static_cast<size_t>(found - edges_.begin()) : size();
  }

 private:
  std::vector<MeshEdge> edges_;
  std::vector<bool> is_first_;  // by vertex: whether an edge begins there
};

// The patches of `suspects` that share no edge with other triangles; `uses` counts all that have an edge.
void drop_loose_patches(const std::vector<Suspect>& suspects, const std::vector<uint32_t>& uses,
                        std::vector<bool>& stands) {
  std::vector<uint32_t> patch_of(uses.size()), own_uses(uses.size());
  std::iota(patch_of.begin(), patch_of.end(), 0u);
  const auto root = [&](uint32_t edge) {
    while (patch_of[edge] != edge) edge = patch_of[edge] = patch_of[patch_of[edge]];
    return edge;
  };
  for (const Suspect& suspect : suspects) {
    for (const uint32_t edge : suspect.edges) {
      ++own_uses[edge];
      patch_of[root(edge)] = root(suspect.edges[0]);
    }
  }
  std::vector<bool> is_anchored(uses.size());
  for (uint32_t edge = 0; edge < uses.size(); ++edge) {
    if (uses[edge] > own_uses[edge]) is_anchored[root(edge)] = true;
  }
  for (const Suspect& suspect : suspects) {
    if (!is_anchored[root(suspect.edges[0])]) stands[suspect.triangle] = false;
  }
}

}  // namespace

void drop_splinters(std::span<const Triangle> triangles, const std::vector<bool>& is_suspect,
                    std::vector<bool>& stands) {
  std::vector<MeshEdge> of_suspects;
  for (size_t t = 0; t < triangles.size(); ++t) {
    if (!stands[t] || !is_suspect[t]) continue;
    for (const MeshEdge& edge : edges_of(triangles[t])) of_suspects.push_back(edge);
  }
  if (of_suspects.empty()) return;
  const EdgeList edges(std::move(of_suspects));

  std::vector<uint32_t> uses(edges.size());  // by how many standing triangles
  std::vector<Suspect> suspects;
  for (size_t t = 0; t < triangles.size(); ++t) {
    if (!stands[t]) continue;
    Suspect suspect{t, {}};
    const std::array<MeshEdge, 3> sides = edges_of(triangles[t]);
    for (size_t k = 0; k < 3; ++k) {
      const size_t edge = edges.find(sides[k]);
      if (edge == edges.size()) continue;
      suspect.edges[k] = static_cast<uint32_t>(edge);
      ++uses[edge];
    }
    if (is_suspect[t]) suspects.push_back(suspect);
  }

  const auto falls = [&](const Suspect& suspect) {
    const auto open =
        std::count_if(suspect.edges.begin(), suspect.edges.end(), [&](uint32_t e) { return uses[e] == 1; });
    if (open < 2) return false;
    for (const uint32_t edge : suspect.edges) --uses[edge];
    stands[suspect.triangle] = false;
    return true;
  };
  while (std::erase_if(suspects, falls) > 0) {
  }
  drop_loose_patches(suspects, uses, stands);
}

}  // namespace kt
