// By sorting: 16 bytes per triangle for the cells; then, for each triangle that may be a splinter, some 70.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/map/overlap.h"

#include <algorithm>
#include <compare>
#include <functional>
#include <limits>
#include <map>
#include <numeric>
#include <utility>

#include "shared/core/check.h"

namespace kt {
namespace {

using Triangle = std::array<uint32_t, 3>;
using MeshEdge = std::pair<uint32_t, uint32_t>;  // welded vertices, the smaller first

std::array<EdgeKey, 3> keys_of(const CloudSlice& slice, size_t triangle) {
  const auto [a, b, c] = slice.triangles[triangle];
  return {slice.vertices[a].key, slice.vertices[b].key, slice.vertices[c].key};
}

bool repeats_a_corner(const std::array<EdgeKey, 3>& keys) {
  return keys[0] == keys[1] || keys[1] == keys[2] || keys[2] == keys[0];
}

// For each slice, 0 for the best; the parts of one slice share it.
std::vector<uint32_t> ranks_of(std::span<const CloudSlice> slices) {
  struct Whole {
    double weight = 0, corners = 0;
    double mean() const { return corners > 0 ? weight / corners : 0; }
  };
  std::map<int64_t, Whole> wholes;  // by sequence
  for (const CloudSlice& slice : slices) {
    Whole& whole = wholes[slice.sequence];
    for (const Triangle& triangle : slice.triangles) {
      for (const uint32_t corner : triangle)
        whole.weight += static_cast<double>(slice.vertices[corner].weight);
    }
    whole.corners += 3 * static_cast<double>(slice.triangles.size());
  }
  std::vector<std::pair<double, int64_t>> best_first;
  for (const auto& [sequence, whole] : wholes) best_first.emplace_back(whole.mean(), sequence);
  std::sort(best_first.begin(), best_first.end(), std::greater<>());
  std::map<int64_t, uint32_t> rank_of;
  for (const auto& [mean, sequence] : best_first)
    rank_of.emplace(sequence, static_cast<uint32_t>(rank_of.size()));
  std::vector<uint32_t> ranks;
  for (const CloudSlice& slice : slices) ranks.push_back(rank_of.at(slice.sequence));
  return ranks;
}

// A triangle in its cell.
struct CellEntry {
  EdgeKey cell;  // of the cell's lowest corner
  uint32_t rank;
  uint32_t source;  // counts the triangles of all slices one after the other
  friend auto operator<=>(const CellEntry&, const CellEntry&) = default;
};

std::array<MeshEdge, 3> edges_of(const Triangle& welded) {
  const auto [a, b, c] = welded;
  return {std::minmax({a, b}), std::minmax({b, c}), std::minmax({c, a})};
}

// Calls visit(slice, triangle, corners) for each standing triangle, corners counting through all slices.
template <typename Visit>
void for_each_standing(std::span<const CloudSlice> slices, const StandingTriangles& stands,
                       const Visit& visit) {
  uint32_t start = 0;
  for (size_t s = 0; s < slices.size(); ++s) {
    for (size_t t = 0; t < slices[s].triangles.size(); ++t) {
      const auto [a, b, c] = slices[s].triangles[t];
      if (stands[s][t]) visit(s, t, Triangle{start + a, start + b, start + c});
    }
    start += static_cast<uint32_t>(slices[s].vertices.size());
  }
}

// By vertex of all slices: whether a fallen triangle of its slice has it.
std::vector<bool> touched_by_fallen(std::span<const CloudSlice> slices, const StandingTriangles& stands) {
  std::vector<bool> touched;
  for (size_t s = 0; s < slices.size(); ++s) {
    const size_t start = touched.size();
    touched.resize(start + slices[s].vertices.size());
    for (size_t t = 0; t < slices[s].triangles.size(); ++t) {
      if (stands[s][t] || repeats_a_corner(keys_of(slices[s], t))) continue;
      for (const uint32_t corner : slices[s].triangles[t]) touched[start + corner] = true;
    }
  }
  return touched;
}

}  // namespace

StandingTriangles one_slice_per_cell(std::span<const CloudSlice> slices) {
  const std::vector<uint32_t> ranks = ranks_of(slices);
  std::vector<CellEntry> entries;
  size_t count = 0;
  for (const CloudSlice& slice : slices) count += slice.triangles.size();
  KT_CHECK(count < std::numeric_limits<uint32_t>::max(), "too many triangles");
  entries.reserve(count);
  uint32_t source = 0;
  for (size_t s = 0; s < slices.size(); ++s) {
    for (size_t t = 0; t < slices[s].triangles.size(); ++t, ++source) {
      const std::array<EdgeKey, 3> keys = keys_of(slices[s], t);
      if (!repeats_a_corner(keys)) entries.push_back({EdgeKey::of(owning_cell(keys), 0), ranks[s], source});
    }
  }
  std::sort(entries.begin(), entries.end());
  std::vector<bool> all(count);
  for (size_t i = 0, first = 0; i < entries.size(); ++i) {
    if (entries[i].cell != entries[first].cell) first = i;
    if (entries[i].rank == entries[first].rank) all[entries[i].source] = true;
  }
  StandingTriangles stands;
  auto begin = all.begin();
  for (const CloudSlice& slice : slices) {
    const auto end = begin + static_cast<std::ptrdiff_t>(slice.triangles.size());
    stands.emplace_back(begin, end);
    begin = end;
  }
  return stands;
}

void drop_splinters(std::span<const CloudSlice> slices, std::span<const uint32_t> index_of,
                    StandingTriangles& stands) {
  struct Suspect {
    size_t slice, triangle;
    Triangle edges;  // numbers of its edges
  };
  const auto welded = [&](const Triangle& corners) {
    return Triangle{index_of[corners[0]], index_of[corners[1]], index_of[corners[2]]};
  };
  const std::vector<bool> touched = touched_by_fallen(slices, stands);
  const auto is_suspect = [&](const Triangle& t) { return touched[t[0]] || touched[t[1]] || touched[t[2]]; };

  // The edges of all suspects, and how many standing triangles each has.
  std::vector<MeshEdge> edges;
  for_each_standing(slices, stands, [&](size_t, size_t, const Triangle& corners) {
    if (!is_suspect(corners)) return;
    for (const MeshEdge& edge : edges_of(welded(corners))) edges.push_back(edge);
  });
  if (edges.empty()) return;
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  std::vector<bool> is_first(*std::max_element(index_of.begin(), index_of.end()) + size_t{1});
  for (const MeshEdge& edge : edges) is_first[edge.first] = true;

  std::vector<uint32_t> uses(edges.size());
  std::vector<Suspect> suspects;
  for_each_standing(slices, stands, [&](size_t s, size_t t, const Triangle& corners) {
    Suspect suspect{s, t, {}};
    const std::array<MeshEdge, 3> sides = edges_of(welded(corners));
    for (size_t k = 0; k < 3; ++k) {
      if (!is_first[sides[k].first]) continue;
      const auto found = std::lower_bound(edges.begin(), edges.end(), sides[k]);
      if (found == edges.end() || *found != sides[k]) continue;
      suspect.edges[k] = static_cast<uint32_t>(found - edges.begin());
      ++uses[suspect.edges[k]];
    }
    if (is_suspect(corners)) suspects.push_back(suspect);
  });

  const auto falls = [&](const Suspect& suspect) {
    const auto open =
        std::count_if(suspect.edges.begin(), suspect.edges.end(), [&](uint32_t e) { return uses[e] == 1; });
    if (open < 2) return false;
    for (const uint32_t edge : suspect.edges) --uses[edge];
    stands[suspect.slice][suspect.triangle] = false;
    return true;
  };
  while (std::erase_if(suspects, falls) > 0) {
  }

  // Patches of suspects; one that shares an edge with anything else stays.
  std::vector<uint32_t> patch_of(edges.size()), own_uses(edges.size());
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
  std::vector<bool> is_anchored(edges.size());
  for (uint32_t edge = 0; edge < edges.size(); ++edge) {
    if (uses[edge] > own_uses[edge]) is_anchored[root(edge)] = true;
  }
  for (const Suspect& suspect : suspects) {
    if (!is_anchored[root(suspect.edges[0])]) stands[suspect.slice][suspect.triangle] = false;
  }
}

}  // namespace kt
