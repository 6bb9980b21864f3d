// Builds the marching cubes table from the contours on the faces of a cell.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/fusion/marching_cubes.h"

#include <algorithm>
#include <array>
#include <vector>

#include "shared/core/check.h"

namespace kt {
namespace {

constexpr int kEdges = 12;

int edge_between(int corner_a, int corner_b) {
  const int low = corner_a & corner_b, difference = corner_a ^ corner_b;
  switch (difference) {
    case 1:
      return 0 + (low >> 1 & 1) + 2 * (low >> 2 & 1);
    case 2:
      return 4 + (low & 1) + 2 * (low >> 2 & 1);
    case 4:
      return 8 + (low & 1) + 2 * (low >> 1 & 1);
    default:
      KT_CHECK(false, "not an edge");
      return -1;
  }
}

// Corners of the six faces, counter-clockwise seen from outside the cell.
constexpr std::array<std::array<int, 4>, 6> kFaces = {
    {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}}};

// Follow[e] = next edge of the contour loop after e, -1 where the contour does not cross e.
std::array<int, kEdges> contour(int pattern) {
  std::array<int, kEdges> follow;
  follow.fill(-1);
  const auto inside = [pattern](int corner) { return (pattern >> corner & 1) != 0; };
  for (const auto& face : kFaces) {
    for (int k = 0; k < 4; ++k) {
      if (inside(face[k]) || !inside(face[(k + 1) % 4])) continue;
      // A run of inside corners begins after corner k; find where it ends.
      int end = k + 1;
      while (inside(face[(end + 1) % 4])) ++end;
      follow[edge_between(face[k], face[(k + 1) % 4])] = edge_between(face[end % 4], face[(end + 1) % 4]);
    }
  }
  return follow;
}

bool on_common_face(int edge_a, int edge_b) {
  const Vec3i a = MarchingCubesTable::edge_start(edge_a), b = MarchingCubesTable::edge_start(edge_b);
  const int along_a = MarchingCubesTable::edge_axis(edge_a), along_b = MarchingCubesTable::edge_axis(edge_b);
  return (along_a != 0 && along_b != 0 && a.x == b.x) || (along_a != 1 && along_b != 1 && a.y == b.y) ||
         (along_a != 2 && along_b != 2 && a.z == b.z);
}

// A fan from loop[0] must not have a diagonal on a face: the cell beside may have the same one.
bool has_diagonal_on_face(const std::vector<int>& loop) {
  for (size_t k = 2; k + 1 < loop.size(); ++k) {
    if (on_common_face(loop[0], loop[k])) return true;
  }
  return false;
}

}  // namespace

MarchingCubesTable make_marching_cubes_table() {
  MarchingCubesTable table;
  for (int pattern = 0; pattern < 256; ++pattern) {
    std::array<int, kEdges> follow = contour(pattern);
    int triangles = 0;
    for (int first = 0; first < kEdges; ++first) {
      std::vector<int> loop;
      for (int edge = first; follow[edge] >= 0;) {
        loop.push_back(edge);
        const int next = follow[edge];
        follow[edge] = -1;
        edge = next;
      }
      while (has_diagonal_on_face(loop)) std::rotate(loop.begin(), loop.begin() + 1, loop.end());
      for (size_t k = 1; k + 1 < loop.size(); ++k) {
        KT_CHECK(triangles < MarchingCubesTable::kMaxTriangles);
        uint8_t* corners = table.edges[pattern] + 3 * triangles++;
        corners[0] = static_cast<uint8_t>(loop[0]);
        corners[1] = static_cast<uint8_t>(loop[k]);
        corners[2] = static_cast<uint8_t>(loop[k + 1]);
      }
    }
    table.triangle_count[pattern] = static_cast<uint8_t>(triangles);
  }
  return table;
}

}  // namespace kt
