// Cuts a slice into parts by its triangles.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/types/cloud_slice.h"

#include <algorithm>

#include "shared/core/check.h"

namespace kt {

namespace {

// Where a part ends that begins with this triangle: `part_of` says in which part each vertex stands last.
size_t part_end(const CloudSlice& slice, size_t begin, size_t max_triangles, size_t max_vertices, size_t part,
                std::vector<size_t>& part_of) {
  const size_t most = begin + std::min(max_triangles, slice.triangles.size() - begin);
  size_t vertices = 0;
  for (size_t i = begin; i < most; ++i) {
    for (const uint32_t corner : slice.triangles[i]) {
      vertices += part_of[corner] != part;
      part_of[corner] = part;
    }
    if (vertices > max_vertices) return i;
  }
  return most;
}

}  // namespace

std::vector<CloudSlice> split_slice(const CloudSlice& slice, size_t max_triangles, size_t max_vertices) {
  KT_CHECK(max_triangles > 0 && max_vertices >= 3);
  std::vector<CloudSlice> parts;
  std::vector<size_t> part_of(slice.vertices.size(), SIZE_MAX);
  size_t begin = 0;
  do {
    const size_t end = part_end(slice, begin, max_triangles, max_vertices, parts.size(), part_of);
    // Ascending indices are ascending keys.
    std::vector<uint32_t> used;
    for (size_t i = begin; i < end; ++i)
      used.insert(used.end(), slice.triangles[i].begin(), slice.triangles[i].end());
    std::sort(used.begin(), used.end());
    used.erase(std::unique(used.begin(), used.end()), used.end());

    CloudSlice part{slice.sequence,
                    slice.segment,
                    slice.timestamp_us,
                    slice.T_odom_camera,
                    slice.voxel_size_m,
                    slice.is_final && end == slice.triangles.size(),
                    {},
                    {}};
    for (const uint32_t vertex : used) part.vertices.push_back(slice.vertices[vertex]);
    for (size_t i = begin; i < end; ++i) {
      part.triangles.push_back(slice.triangles[i]);
      for (uint32_t& corner : part.triangles.back()) {
        corner = static_cast<uint32_t>(std::lower_bound(used.begin(), used.end(), corner) - used.begin());
      }
    }
    parts.push_back(std::move(part));
    begin = end;
  } while (begin < slice.triangles.size());
  return parts;
}

}  // namespace kt
