// Tests of the derived marching cubes table: closed, consistently oriented, outward, convergent.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/fusion/marching_cubes.h"

#include <cmath>
#include <functional>
#include <numbers>

#include "gtest/gtest.h"

#include "shared/core/rng.h"
#include "tests/onboard/fusion/mesh.h"

namespace kt::test {
namespace {

// All triangles of a field on an n x n x n grid of corners.
std::vector<KeyTriangle> triangulate(int n, const std::function<bool(Vec3i)>& is_inside) {
  static const MarchingCubesTable table = make_marching_cubes_table();
  std::vector<KeyTriangle> triangles;
  for (int z = 0; z + 1 < n; ++z) {
    for (int y = 0; y + 1 < n; ++y) {
      for (int x = 0; x + 1 < n; ++x) {
        const Vec3i cell{x, y, z};
        int pattern = 0;
        for (int c = 0; c < 8; ++c) pattern |= is_inside(cell + Vec3i{c & 1, c >> 1 & 1, c >> 2}) << c;
        for (int t = 0; t < table.triangle_count[pattern]; ++t) {
          KeyTriangle triangle;
          for (int k = 0; k < 3; ++k) {
            const int edge = table.edges[pattern][3 * t + k];
            triangle[static_cast<size_t>(k)] =
                EdgeKey::of(cell + MarchingCubesTable::edge_start(edge), MarchingCubesTable::edge_axis(edge));
          }
          triangles.push_back(triangle);
        }
      }
    }
  }
  return triangles;
}

TEST(MarchingCubes, EmptyAndFullCellsHaveNoTriangle) {
  const MarchingCubesTable table = make_marching_cubes_table();
  EXPECT_EQ(table.triangle_count[0], 0);
  EXPECT_EQ(table.triangle_count[255], 0);
  for (int pattern = 1; pattern < 255; ++pattern) EXPECT_GT(table.triangle_count[pattern], 0) << pattern;
}

TEST(MarchingCubes, TrianglesUseExactlyTheEdgesWithASignChange) {
  const MarchingCubesTable table = make_marching_cubes_table();
  for (int pattern = 0; pattern < 256; ++pattern) {
    bool used[12] = {};
    for (int k = 0; k < 3 * table.triangle_count[pattern]; ++k) used[table.edges[pattern][k]] = true;
    for (int edge = 0; edge < 12; ++edge) {
      const Vec3i start = MarchingCubesTable::edge_start(edge);
      const int corner = start.x | start.y << 1 | start.z << 2,
                other = corner | 1 << MarchingCubesTable::edge_axis(edge);
      EXPECT_EQ(used[edge], (pattern >> corner & 1) != (pattern >> other & 1)) << pattern << " edge " << edge;
    }
  }
}

// With all outer corners outside, the surface has no rim: each edge must be met once in either direction.
TEST(MarchingCubes, RandomFieldsGiveClosedOrientedManifolds) {
  constexpr int kSide = 8;
  for (uint64_t trial = 0; trial < 100; ++trial) {
    const double share = 0.1 + 0.008 * static_cast<double>(trial);
    const auto inside = [&](Vec3i v) {
      const bool outer =
          v.x == 0 || v.y == 0 || v.z == 0 || v.x == kSide - 1 || v.y == kSide - 1 || v.z == kSide - 1;
      return !outer &&
             random_uniform(trial, 0, static_cast<uint64_t>((v.z * kSide + v.y) * kSide + v.x)) < share;
    };
    const std::vector<KeyTriangle> triangles = triangulate(kSide, inside);
    ASSERT_FALSE(triangles.empty());
    EXPECT_TRUE(unmatched_edges(triangles).empty()) << "trial " << trial;
    std::map<KeyEdge, int> directed;
    for (const KeyTriangle& triangle : triangles) {
      for (size_t k = 0; k < 3; ++k) ++directed[{triangle[k], triangle[(k + 1) % 3]}];
    }
    for (const auto& [edge, count] : directed) ASSERT_EQ(count, 1) << "trial " << trial;
  }
}

struct Measure {
  double area = 0, volume = 0, least_outward = 1;
};

// A unit sphere on a grid of `n` corners per axis; vertices by linear interpolation of its distance.
Measure measure_sphere(int n) {
  const double step = 2.4 / (n - 1);
  const auto corner = [&](Vec3i v) -> Eigen::Vector3d {
    return Eigen::Vector3d(v.x, v.y, v.z) * step - Eigen::Vector3d(1.19, 1.21, 1.2);
  };
  const auto distance = [&](Vec3i v) { return corner(v).norm() - 1; };
  // The key of an edge is told apart by its bits alone; its place is remembered beside it.
  std::map<EdgeKey, Eigen::Vector3d> places;
  for (int z = 0; z < n; ++z) {
    for (int y = 0; y < n; ++y) {
      for (int x = 0; x < n; ++x) {
        for (int axis = 0; axis < 3; ++axis) {
          const Vec3i a{x, y, z}, b = a + Vec3i{axis == 0, axis == 1, axis == 2};
          places[EdgeKey::of(a, axis)] =
              corner(a) + distance(a) / (distance(a) - distance(b)) * (corner(b) - corner(a));
        }
      }
    }
  }
  Measure measure;
  for (const KeyTriangle& triangle : triangulate(n, [&](Vec3i v) { return distance(v) < 0; })) {
    const Eigen::Vector3d a = places.at(triangle[0]), b = places.at(triangle[1]), c = places.at(triangle[2]);
    const Eigen::Vector3d normal = (b - a).cross(c - a);
    measure.area += normal.norm() / 2;
    measure.volume += a.dot(b.cross(c)) / 6;
    if (normal.norm() > 1e-9)
      measure.least_outward =
          std::min(measure.least_outward, normal.normalized().dot((a + b + c).normalized()));
  }
  return measure;
}

TEST(MarchingCubes, SphereFacesOutwardAndItsAreaAndVolumeConverge) {
  constexpr double kArea = 4 * std::numbers::pi, kVolume = kArea / 3;
  double last_area_error = 1, last_volume_error = 1;
  for (const int n : {10, 20, 40}) {
    const Measure measure = measure_sphere(n);
    EXPECT_GT(measure.least_outward, 0.5) << n;
    const double area_error = std::abs(measure.area / kArea - 1),
                 volume_error = std::abs(measure.volume / kVolume - 1);
    EXPECT_LT(area_error, last_area_error / 2) << n;
    EXPECT_LT(volume_error, last_volume_error / 2) << n;
    last_area_error = area_error;
    last_volume_error = volume_error;
  }
  EXPECT_LT(last_area_error, 0.01);
  EXPECT_LT(last_volume_error, 0.01);
}

}  // namespace
}  // namespace kt::test
