// Finds the triangles of a mesh that a short straight line crosses.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <optional>
#include <vector>

#include "shared/io/mesh.h"

namespace kt {

/// The triangles of a mesh, sorted by the cells of a grid that their bounds touch: 16 bytes for each cell of
/// each triangle while that is made, then 4. The mesh has to live as long, unchanged.
class TriangleGrid {
 public:
  /// Cells of `cell_size_m`, a half to a quarter of the lines that will be asked for. Positions are finite
  /// and within 2^20 cells of the origin.
  TriangleGrid(const Mesh& mesh, double cell_size_m);

  /// Whether accept(triangle, t) is true for a triangle that the line from `a` to `b` crosses, at a + t (b -
  /// a), t from 0 to 1. Triangles come in a fixed order, some more than once; after the first that is
  /// accepted no more are asked.
  template <typename Accept>
  bool any_crossed(Vec3f a, Vec3f b, const Accept& accept) const {
    const auto crosses = [&](uint32_t triangle) {
      const std::optional<double> t = crossing(a, b, triangle);
      return t && accept(triangle, *t);
    };
    if (std::any_of(large_.begin(), large_.end(), crosses)) return true;
    const int pieces = pieces_of(a, b);
    for (int i = 0; i < pieces; ++i) {
      const auto at = [&](int k) {
        return a + (static_cast<float>(k) / static_cast<float>(pieces)) * (b - a);
      };
      const Box box = cells_of({at(i), at(i + 1)});
      for (int64_t z = box.low[2]; z <= box.high[2]; ++z) {
        for (int64_t y = box.low[1]; y <= box.high[1]; ++y) {
          const uint64_t last = key_of(box.high[0], y, z);
          auto cell = std::lower_bound(cells_.begin(), cells_.end(), key_of(box.low[0], y, z));
          for (; cell != cells_.end() && *cell <= last; ++cell) {
            const auto row = starts_.begin() + (cell - cells_.begin());
            const auto begin = triangles_.begin() + row[0], end = triangles_.begin() + row[1];
            if (std::any_of(begin, end, crosses)) return true;
          }
        }
      }
    }
    return false;
  }

 private:
  struct Box {
    std::array<int64_t, 3> low, high;  // cells, both inclusive
    int64_t size() const { return (high[0] - low[0] + 1) * (high[1] - low[1] + 1) * (high[2] - low[2] + 1); }
  };

  static constexpr int kBits = 21;
  // x in the lowest bits, so that the cells of a row are neighbours.
  static uint64_t key_of(int64_t x, int64_t y, int64_t z) {
    const auto field = [](int64_t i) { return static_cast<uint64_t>(i + (int64_t{1} << (kBits - 1))); };
    return field(z) << (2 * kBits) | field(y) << kBits | field(x);
  }
  Box cells_of(std::initializer_list<Vec3f> points) const;
  // Of about the length of a cell: their boxes hold few cells beside the line.
  int pieces_of(Vec3f a, Vec3f b) const {
    return std::max(1, static_cast<int>(std::ceil(static_cast<double>(norm(b - a)) / cell_size_m_)));
  }
  std::optional<double> crossing(Vec3f a, Vec3f b, uint32_t triangle) const;

  const Mesh& mesh_;
  double cell_size_m_;
  std::vector<uint64_t> cells_;   // those that hold triangles, ascending
  std::vector<uint32_t> starts_;  // of their triangles, and the end
  std::vector<uint32_t> triangles_;
  std::vector<uint32_t> large_;  // those that would fill too many cells
};

}  // namespace kt
