// A tree of boxes over the triangles of a mesh that finds the closest one to a point.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "shared/io/mesh.h"

namespace kt {

/// Squared distance (m^2) of `p` to the triangle a b c, exact; it may be degenerate.
double squared_distance_to_triangle(const Eigen::Vector3d& p, const Eigen::Vector3d& a,
                                    const Eigen::Vector3d& b, const Eigen::Vector3d& c);

class TriangleTree {
 public:
  /// Copies what it needs; throws kt::Error where the mesh has no triangles. Memory: 56 bytes per triangle.
  /// `threads` (0 = one per core) build it; the tree does not depend on it.
  explicit TriangleTree(const Mesh& mesh, int threads = 0);

  struct Nearest {
    double squared_distance = 0;  ///< m^2
    uint32_t slot = 0;            ///< where the tree keeps that triangle: a good guess for a point near by
  };
  /// The triangle closest to `p`. `guess` is the slot of any triangle: the closer it is, the faster.
  Nearest nearest(const Eigen::Vector3d& p, uint32_t guess = 0) const;

 private:
  static constexpr size_t kLeafSize = 4;
  using Triangle = std::array<Vec3f, 3>;
  struct Node {
    Vec3f low, high;
    uint32_t first =
        0;  ///< leaf: slot of its first triangle; inner: its right child, the left one is next to it
    uint32_t count = 0;  ///< triangles of a leaf; 0 = inner
  };
  struct Item {
    Vec3f centre;
    uint32_t triangle;
  };
  static size_t node_count(size_t triangles);
  void build(const Mesh& mesh, std::vector<Item>& items, size_t begin, size_t end, size_t node, int threads);

  std::vector<Node> nodes_;
  std::vector<Triangle> triangles_;  ///< in the order of the leaves
};

}  // namespace kt
