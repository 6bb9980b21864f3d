// Finds splinters by the open edges of suspects: some 70 bytes for each suspect.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/map/splinters.h"

#include <algorithm>
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

// Suspects that hang on no other triangle, or only by a long way over suspects; `uses` counts all that have
// an edge.
void drop_loose(const std::vector<Suspect>& suspects, const std::vector<uint32_t>& uses,
                std::vector<bool>& stands) {
  std::vector<uint32_t> own_uses(uses.size());
  for (const Suspect& suspect : suspects) {
    for (const uint32_t edge : suspect.edges) ++own_uses[edge];
  }
  std::vector<bool> is_anchored(uses.size());  // by edge
  for (size_t edge = 0; edge < uses.size(); ++edge) is_anchored[edge] = uses[edge] > own_uses[edge];
  const auto hangs = [&](const Suspect& suspect) {
    return std::any_of(suspect.edges.begin(), suspect.edges.end(),
                       [&](uint32_t edge) { return is_anchored[edge]; });
  };
  std::vector<const Suspect*> loose;
  for (const Suspect& suspect : suspects) loose.push_back(&suspect);
  for (int round = 0; round < kSplinterRounds && !loose.empty(); ++round) {
    const auto found =
        std::partition(loose.begin(), loose.end(), [&](const Suspect* s) { return !hangs(*s); });
    for (auto suspect = found; suspect != loose.end(); ++suspect) {
      for (const uint32_t edge : (*suspect)->edges) is_anchored[edge] = true;
    }
    loose.erase(found, loose.end());
  }
  for (const Suspect* suspect : loose) stands[suspect->triangle] = false;
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

  const auto is_splinter = [&uses](const Suspect& suspect) {
    const auto is_open = [&uses](uint32_t edge) { return uses[edge] == 1; };
    return std::count_if(suspect.edges.begin(), suspect.edges.end(), is_open) >= 2;
  };
  for (int round = 0; round < kSplinterRounds; ++round) {
    const auto fallen = std::partition(suspects.begin(), suspects.end(),
                                       [&](const Suspect& suspect) { return !is_splinter(suspect); });
    if (fallen == suspects.end()) break;
    for (auto suspect = fallen; suspect != suspects.end(); ++suspect) {
      for (const uint32_t edge : suspect->edges) --uses[edge];
      stands[suspect->triangle] = false;
    }
    suspects.erase(fallen, suspects.end());
  }
  drop_loose(suspects, uses, stands);
}

}  // namespace kt
