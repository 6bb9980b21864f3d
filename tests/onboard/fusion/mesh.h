// Meshes as sets of triangles between voxel edges: what the tests of slices compare.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <map>
#include <tuple>
#include <vector>

#include "shared/types/cloud_slice.h"

namespace kt::test {

/// Corners as keys, turned so that the smallest comes first: equal triangles compare equal, mirrored ones do
/// not.
using KeyTriangle = std::array<EdgeKey, 3>;
using KeyEdge = std::pair<EdgeKey, EdgeKey>;

inline KeyTriangle turned(KeyTriangle corners) {
  std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());
  return corners;
}

/// Several slices welded by key.
struct KeyedMesh {
  std::map<EdgeKey, SliceVertex> vertices;  ///< the first slice's where several hold one
  std::vector<KeyTriangle> triangles;       ///< sorted

  KeyedMesh() = default;
  explicit KeyedMesh(const std::vector<CloudSlice>& slices) {
    for (const CloudSlice& slice : slices) {
      for (const SliceVertex& vertex : slice.vertices) vertices.emplace(vertex.key, vertex);
      for (const auto& [a, b, c] : slice.triangles) {
        triangles.push_back(
            turned({slice.vertices.at(a).key, slice.vertices.at(b).key, slice.vertices.at(c).key}));
      }
    }
    std::sort(triangles.begin(), triangles.end());
  }

  bool has_duplicate_triangle() const {
    return std::adjacent_find(triangles.begin(), triangles.end()) != triangles.end();
  }

  Eigen::Vector3d position(EdgeKey key) const {
    const Vec3f p = vertices.at(key).p_odom;
    return {p.x, p.y, p.z};
  }
};

/// How often each directed edge is used, against how often its reverse is: 0 for every edge of a closed,
/// oriented mesh.
inline std::map<KeyEdge, int> unmatched_edges(const std::vector<KeyTriangle>& triangles) {
  std::map<KeyEdge, int> balance;
  for (const KeyTriangle& triangle : triangles) {
    for (size_t k = 0; k < 3; ++k) {
      const EdgeKey a = triangle[k], b = triangle[(k + 1) % 3];
      balance[std::minmax(a, b)] += a < b ? 1 : -1;
    }
  }
  std::erase_if(balance, [](const auto& entry) { return entry.second == 0; });
  return balance;
}

/// What a vertex says of the surface, without what depends on its neighbourhood or on time.
inline auto content(const SliceVertex& v) {
  return std::make_tuple(v.key, v.p_odom.x, v.p_odom.y, v.p_odom.z, v.weight, v.colour.r, v.colour.g,
                         v.colour.b);
}

}  // namespace kt::test
