// Cuts a slice into parts by its triangles.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/types/cloud_slice.h"

#include <algorithm>
#include <limits>
#include <numeric>

#include "shared/core/check.h"

namespace kt {

namespace {

// Where a part ends that begins with this triangle: `last_part` says in which part each vertex stands last.
size_t part_end(const CloudSlice& slice, size_t begin, size_t max_triangles, size_t max_vertices, size_t part,
                std::vector<size_t>& last_part) {
  const size_t most = begin + std::min(max_triangles, slice.triangles.size() - begin);
  size_t vertices = 0;
  for (size_t i = begin; i < most; ++i) {
    for (const uint32_t corner : slice.triangles[i]) {
      vertices += last_part[corner] != part;
      last_part[corner] = part;
    }
    if (vertices > max_vertices) return i;
  }
  return most;
}

}  // namespace

CloudSlice part_of(const CloudSlice& slice, std::span<const uint32_t> triangles) {
  CloudSlice part;
  part.sequence = slice.sequence;
  part.segment = slice.segment;
  part.timestamp_us = slice.timestamp_us;
  part.T_odom_camera = slice.T_odom_camera;
  part.voxel_size_m = slice.voxel_size_m;
  uint32_t low = std::numeric_limits<uint32_t>::max(), high = 0;
  for (const uint32_t t : triangles) {
    part.triangles.push_back(slice.triangles[t]);
    const auto [least, greatest] = std::minmax_element(slice.triangles[t].begin(), slice.triangles[t].end());
    low = std::min(low, *least), high = std::max(high, *greatest);
  }
  if (triangles.empty()) return part;
  constexpr uint32_t kUnused = std::numeric_limits<uint32_t>::max();
  std::vector<uint32_t> index(high - low + size_t{1}, kUnused);  // of the vertices from low to high
  for (const auto& triangle : part.triangles) {
    for (const uint32_t corner : triangle) index[corner - low] = 0;
  }
  for (size_t i = 0; i < index.size(); ++i) {
    if (index[i] == kUnused) continue;
    index[i] = static_cast<uint32_t>(part.vertices.size());
    part.vertices.push_back(slice.vertices[low + i]);
  }
  for (auto& triangle : part.triangles) {
    for (uint32_t& corner : triangle) corner = index[corner - low];
  }
  return part;
}

std::vector<CloudSlice> split_slice(const CloudSlice& slice, size_t max_triangles, size_t max_vertices) {
  KT_CHECK(max_triangles > 0 && max_vertices >= 3);
  std::vector<CloudSlice> parts;
  std::vector<uint32_t> triangles;
  std::vector<size_t> last_part(slice.vertices.size(), SIZE_MAX);
  size_t begin = 0;
  do {
    const size_t end = part_end(slice, begin, max_triangles, max_vertices, parts.size(), last_part);
    triangles.resize(end - begin);
    std::iota(triangles.begin(), triangles.end(), static_cast<uint32_t>(begin));
    parts.push_back(part_of(slice, triangles));
    begin = end;
  } while (begin < slice.triangles.size());
  parts.back().is_final = slice.is_final;
  return parts;
}

}  // namespace kt
