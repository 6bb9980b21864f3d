// Count, scan, write; then indices by binary search over the sorted keys.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/fusion/slice_extractor.h"

#include <algorithm>

#include "shared/exec/compact.h"
#include "shared/exec/for_each.h"

namespace kt {

SliceExtractor::SliceExtractor(const exec::Device& device, int64_t brick_count)
    : device_(device), table_(device, 1), selected_(device, brick_count), slots_(device, brick_count) {
  const MarchingCubesTable table = make_marching_cubes_table();
  table_.upload({&table, 1});
}

CloudSlice SliceExtractor::extract(const ExportRule& rule) {
  constexpr int64_t kRows = kBrickSide * kBrickSide;
  exec::for_each(device_, selected_.size(), SelectExportBrick{rule, selected_.data()});
  const int64_t bricks = exec::compact_flags(device_, selected_.data(), selected_.size(), slots_.data());
  const int64_t rows = bricks * kRows;

  const SliceRow row{rule, table_.data(), slots_.data()};
  exec::Buffer<int32_t> vertex_counts(device_, rows), triangle_counts(device_, rows);
  exec::for_each(device_, rows, CountSliceRow{row, vertex_counts.data(), triangle_counts.data()});
  exec::Buffer<int32_t> vertex_offsets(device_, rows), triangle_offsets(device_, rows);
  exec::Buffer<SliceVertex> vertices(
      device_, exec::exclusive_scan(device_, vertex_counts.data(), rows, vertex_offsets.data()));
  exec::Buffer<SliceTriangle> triangles(
      device_, exec::exclusive_scan(device_, triangle_counts.data(), rows, triangle_offsets.data()));
  exec::for_each(
      device_, rows,
      WriteSliceRow{row, vertex_offsets.data(), triangle_offsets.data(), vertices.data(), triangles.data()});

  exec::Buffer<uint8_t> masks(device_, rows);
  exec::for_each(device_, rows, MarkFrozenRow{rule, slots_.data(), masks.data()});
  exec::for_each(device_, rows, FreezeRow{rule.volume, slots_.data(), masks.data()});
  exec::for_each(device_, bricks, ClearBrick{rule.volume, rule.after, slots_.data()});

  CloudSlice slice;
  slice.voxel_size_m = static_cast<double>(rule.volume.voxel_size_m);
  slice.vertices = vertices.downloaded();
  std::sort(slice.vertices.begin(), slice.vertices.end(),
            [](const SliceVertex& a, const SliceVertex& b) { return a.key < b.key; });
  const std::vector<SliceTriangle> keyed = triangles.downloaded();
  slice.triangles.reserve(keyed.size());
  for (const SliceTriangle& triangle : keyed) {
    std::array<uint32_t, 3> corners;
    for (size_t k = 0; k < 3; ++k) {
      const auto found =
          std::lower_bound(slice.vertices.begin(), slice.vertices.end(), triangle.corners[k],
                           [](const SliceVertex& vertex, EdgeKey key) { return vertex.key < key; });
      KT_CHECK(found != slice.vertices.end() && found->key == triangle.corners[k],
               "triangle on an edge without a vertex");
      corners[k] = static_cast<uint32_t>(found - slice.vertices.begin());
    }
    slice.triangles.push_back(corners);
  }
  return slice;
}

}  // namespace kt
