// Finds the triangles of a mesh that a short straight line crosses.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <compare>
#include <cstdint>
#include <initializer_list>
#include <optional>
#include <vector>

#include "shared/io/mesh.h"

namespace kt {

/// The triangles of a mesh, sorted by the cells of a grid that their bounds touch: 16 bytes for each cell of
/// each triangle. The mesh has to live as long, unchanged.
class TriangleGrid {
 public:
  /// Cells of `cell_size_m`, about as long as the lines that will be asked for. Positions are finite and
  /// within 2^20 cells of the origin.
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
    const Box box = cells_of({a, b});
    for (int64_t z = box.low[2]; z <= box.high[2]; ++z) {
      for (int64_t y = box.low[1]; y <= box.high[1]; ++y) {
        const uint64_t last = key_of(box.high[0], y, z);
        auto entry = std::lower_bound(entries_.begin(), entries_.end(), Entry{key_of(box.low[0], y, z), 0});
        for (; entry != entries_.end() && entry->cell <= last; ++entry) {
          if (crosses(entry->triangle)) return true;
        }
      }
    }
    return false;
  }

 private:
  struct Entry {
    uint64_t cell;  // x in the lowest bits, so that the cells of a row are neighbours
    uint32_t triangle;
    friend auto operator<=>(const Entry&, const Entry&) = default;
  };
  struct Box {
    std::array<int64_t, 3> low, high;  // cells, both inclusive
    int64_t size() const { return (high[0] - low[0] + 1) * (high[1] - low[1] + 1) * (high[2] - low[2] + 1); }
  };

  static constexpr int kBits = 21;
  static uint64_t key_of(int64_t x, int64_t y, int64_t z) {
    const auto field = [](int64_t i) { return static_cast<uint64_t>(i + (int64_t{1} << (kBits - 1))); };
    return field(z) << (2 * kBits) | field(y) << kBits | field(x);
  }
  Box cells_of(std::initializer_list<Vec3f> points) const;
  std::optional<double> crossing(Vec3f a, Vec3f b, uint32_t triangle) const;

  const Mesh& mesh_;
  double cell_size_m_;
  std::vector<Entry> entries_;
  std::vector<uint32_t> large_;  // those that would fill too many cells
};

}  // namespace kt
