// Slices as marching cubes makes them of a given inside, for the tests of welding.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <map>

#include "offboard/map/overlap.h"
#include "onboard/fusion/marching_cubes.h"
#include "shared/types/cloud_slice.h"

namespace kt::test {

/// The surface in the cells [low, high), vertices half-way along their edges; voxels of 1 cm.
inline CloudSlice made_slice(Vec3i low, Vec3i high, float weight,
                             const std::function<bool(Vec3i)>& is_inside) {
  static const MarchingCubesTable table = make_marching_cubes_table();
  std::vector<std::array<EdgeKey, 3>> triangles;
  std::map<EdgeKey, uint32_t> index_of;
  for (int z = low.z; z < high.z; ++z) {
    for (int y = low.y; y < high.y; ++y) {
      for (int x = low.x; x < high.x; ++x) {
        const Vec3i cell{x, y, z};
        int pattern = 0;
        for (int c = 0; c < 8; ++c) pattern |= is_inside(cell + Vec3i{c & 1, c >> 1 & 1, c >> 2}) << c;
        for (int t = 0; t < table.triangle_count[pattern]; ++t) {
          for (int k = 0; k < 3; ++k) {
            const int edge = table.edges[pattern][3 * t + k];
            const EdgeKey key =
                EdgeKey::of(cell + MarchingCubesTable::edge_start(edge), MarchingCubesTable::edge_axis(edge));
            index_of.emplace(key, 0);
            if (k == 0) triangles.emplace_back();
            triangles.back()[static_cast<size_t>(k)] = key;
          }
        }
      }
    }
  }
  CloudSlice slice;
  slice.voxel_size_m = 0.01;
  for (auto& [key, index] : index_of) {
    index = static_cast<uint32_t>(slice.vertices.size());
    const Vec3i v = key.voxel();
    Vec3f p{static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
    (key.axis() == 0 ? p.x : key.axis() == 1 ? p.y : p.z) += 0.5f;
    slice.vertices.push_back({key, p * 0.01f, {0, 0, 1}, {}, weight, 0});
  }
  for (const auto& [a, b, c] : triangles)
    slice.triangles.push_back({index_of.at(a), index_of.at(b), index_of.at(c)});
  return slice;
}

/// A level floor over the cells [x0, x1) x [0, 6), its voxels up to z = 0, and at `raised` up to 1.
inline CloudSlice made_floor(int x0, int x1, float weight, const std::vector<Vec3i>& raised = {}) {
  return made_slice({x0, 0, -2}, {x1, 6, 4}, weight, [&](Vec3i v) {
    bool is_raised = false;
    for (const Vec3i r : raised) is_raised |= v.x == r.x && v.y == r.y;
    return v.z <= (is_raised ? 1 : 0);
  });
}

inline SliceWeights weights_of(const std::vector<CloudSlice>& slices) {
  SliceWeights weights;
  for (const CloudSlice& slice : slices) weights.add(slice);
  return weights;
}

/// Numbered, each of another sequence.
inline std::vector<CloudSlice> in_sequence(std::vector<CloudSlice> slices) {
  for (size_t i = 0; i < slices.size(); ++i) slices[i].sequence = static_cast<int64_t>(i);
  return slices;
}

}  // namespace kt::test
