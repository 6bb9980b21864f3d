// By sorting: 16 bytes per triangle for the cells; then 12, and some 70 for each triangle that may be a
// splinter.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/map/overlap.h"

#include <algorithm>
#include <compare>
#include <functional>
#include <limits>
#include <utility>

#include "offboard/map/splinters.h"
#include "shared/core/check.h"

namespace kt {
namespace {

using Triangle = std::array<uint32_t, 3>;

std::array<EdgeKey, 3> keys_of(const CloudSlice& slice, size_t triangle) {
  const auto [a, b, c] = slice.triangles[triangle];
  return {slice.vertices[a].key, slice.vertices[b].key, slice.vertices[c].key};
}

bool repeats_a_corner(const std::array<EdgeKey, 3>& keys) {
  return keys[0] == keys[1] || keys[1] == keys[2] || keys[2] == keys[0];
}

// For each slice, 0 for the best; the parts of one slice share it.
std::vector<uint32_t> ranks_of(std::span<const CloudSlice> slices, const SliceWeights& weights) {
  std::vector<std::pair<double, int64_t>> best_first;
  for (const CloudSlice& slice : slices)
    best_first.emplace_back(weights.mean(slice.sequence), slice.sequence);
  std::sort(best_first.begin(), best_first.end(), std::greater<>());
  best_first.erase(std::unique(best_first.begin(), best_first.end()), best_first.end());
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

void SliceWeights::add(const CloudSlice& slice) {
  Sum& sum = sums_[slice.sequence];
  for (const Triangle& triangle : slice.triangles) {
    for (const uint32_t corner : triangle) sum.weight += static_cast<double>(slice.vertices[corner].weight);
  }
  sum.corners += 3 * static_cast<double>(slice.triangles.size());
}

double SliceWeights::mean(int64_t sequence) const {
  const Sum& sum = sums_.at(sequence);
  return sum.corners > 0 ? sum.weight / sum.corners : 0;
}

StandingTriangles one_slice_per_cell(std::span<const CloudSlice> slices, const SliceWeights& weights) {
  const std::vector<uint32_t> ranks = ranks_of(slices, weights);
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
  const std::vector<bool> touched = touched_by_fallen(slices, stands);
  std::vector<Triangle> welded;
  std::vector<bool> is_suspect, all;
  uint32_t start = 0;
  for (size_t s = 0; s < slices.size(); ++s) {
    for (size_t t = 0; t < slices[s].triangles.size(); ++t) {
      const auto [a, b, c] = slices[s].triangles[t];
      welded.push_back({index_of[start + a], index_of[start + b], index_of[start + c]});
      is_suspect.push_back(touched[start + a] || touched[start + b] || touched[start + c]);
      all.push_back(stands[s][t]);
    }
    start += static_cast<uint32_t>(slices[s].vertices.size());
  }
  drop_splinters(welded, is_suspect, all);
  auto begin = all.begin();
  for (std::vector<bool>& of_slice : stands) {
    const auto end = begin + static_cast<std::ptrdiff_t>(of_slice.size());
    of_slice.assign(begin, end);
    begin = end;
  }
}

}  // namespace kt
