// Distances to triangles and surfaces against closed forms and brute force.
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/eval/surface_error.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <numbers>

#include "shared/core/rng.h"
#include "tests/support/test_files.h"
#include "tools/eval/triangle_tree.h"

namespace kt {
namespace {

using Eigen::Vector3d;
using ::testing::HasSubstr;

const SurfaceErrorOptions kQuick{.threshold_m = 0.02, .samples = 20'000};

Vector3d random_point(uint64_t seed, uint64_t i, double scale = 1) {
  return scale * Vector3d(random_normal(seed, 0, i), random_normal(seed, 1, i), random_normal(seed, 2, i));
}

/// A wall of width x height cells of 5 cm in the plane z = z_m, from x = x_m on.
Mesh wall(int width, int height, float x_m, float z_m) {
  Mesh mesh;
  const auto index = [&](int i, int j) { return static_cast<uint32_t>(j * (width + 1) + i); };
  for (int j = 0; j <= height; ++j) {
    for (int i = 0; i <= width; ++i)
      mesh.vertices.push_back({x_m + 0.05f * static_cast<float>(i), 0.05f * static_cast<float>(j), z_m});
  }
  for (int j = 0; j < height; ++j) {
    for (int i = 0; i < width; ++i) {
      mesh.triangles.push_back({index(i, j), index(i + 1, j), index(i + 1, j + 1)});
      mesh.triangles.push_back({index(i, j), index(i + 1, j + 1), index(i, j + 1)});
    }
  }
  return mesh;
}

Mesh sphere(double radius_m, int rings) {
  Mesh mesh;
  const int sectors = 2 * rings;
  for (int j = 0; j <= rings; ++j) {
    for (int i = 0; i <= sectors; ++i) {
      const double polar = std::numbers::pi * j / rings, azimuth = 2 * std::numbers::pi * i / sectors;
      mesh.vertices.push_back({static_cast<float>(radius_m * std::sin(polar) * std::cos(azimuth)),
                               static_cast<float>(radius_m * std::sin(polar) * std::sin(azimuth)),
                               static_cast<float>(radius_m * std::cos(polar))});
    }
  }
  for (int j = 0; j < rings; ++j) {
    for (int i = 0; i < sectors; ++i) {
      const auto a = static_cast<uint32_t>(j * (sectors + 1) + i), c = a + static_cast<uint32_t>(sectors) + 1;
      mesh.triangles.push_back({a, c, a + 1});
      mesh.triangles.push_back({a + 1, c, c + 1});
    }
  }
  return mesh;
}

/// The closest point by dense search over the triangle, good to `step`.
double slow_distance(const Vector3d& p, const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  double best = std::numeric_limits<double>::infinity();
  constexpr int kSteps = 300;
  for (int i = 0; i <= kSteps; ++i) {
    for (int j = 0; i + j <= kSteps; ++j) {
      best = std::min(best, (p - (a + (b - a) * i / kSteps + (c - a) * j / kSteps)).norm());
    }
  }
  return best;
}

TEST(TriangleDistance, AgreesWithADenseSearch) {
  for (uint64_t i = 0; i < 200; ++i) {
    const Vector3d p = random_point(1, i), a = random_point(2, i), b = random_point(3, i),
                   c = random_point(4, i);
    const double exact = std::sqrt(squared_distance_to_triangle(p, a, b, c)),
                 searched = slow_distance(p, a, b, c);
    EXPECT_LE(exact, searched + 1e-12) << i;
    EXPECT_NEAR(exact, searched, 0.02) << i;
  }
}

TEST(TriangleDistance, DegenerateTrianglesAreSegmentsAndPoints) {
  const Vector3d o(0, 0, 0), x(1, 0, 0), p(0.5, 2, 0);
  EXPECT_DOUBLE_EQ(squared_distance_to_triangle(p, o, x, 0.25 * x), 4);
  EXPECT_DOUBLE_EQ(squared_distance_to_triangle(p, o, o, o), 4.25);
  EXPECT_DOUBLE_EQ(squared_distance_to_triangle({3, 0, 0}, o, x, x), 4);
}

TEST(TriangleTree, AgreesWithASearchThroughAllTriangles) {
  Mesh mesh;
  for (uint64_t i = 0; i < 3000; ++i) {
    const Vector3d p = random_point(7, i / 3) + random_point(8, i, 0.1);
    mesh.vertices.push_back(
        {static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z())});
    if (i % 3 == 2)
      mesh.triangles.push_back(
          {static_cast<uint32_t>(i) - 2, static_cast<uint32_t>(i) - 1, static_cast<uint32_t>(i)});
  }
  const TriangleTree tree(mesh);
  uint32_t guess = 0;
  for (uint64_t i = 0; i < 500; ++i) {
    const Vector3d p = random_point(9, i, 1.5);
    double expected = std::numeric_limits<double>::infinity();
    for (const auto& triangle : mesh.triangles) {
      Vector3d corners[3];
      for (size_t k = 0; k < 3; ++k)
        corners[k] = {mesh.vertices[triangle[k]].x, mesh.vertices[triangle[k]].y,
                      mesh.vertices[triangle[k]].z};
      expected = std::min(expected, squared_distance_to_triangle(p, corners[0], corners[1], corners[2]));
    }
    const TriangleTree::Nearest nearest = tree.nearest(p, guess);
    EXPECT_EQ(nearest.squared_distance, expected) << i;
    guess = nearest.slot;
  }
}

TEST(TriangleTree, WorksForAnyNumberOfTriangles) {
  for (int count = 1; count <= 40; ++count) {
    const Mesh mesh = wall(count, 1, 0, 0);
    const TriangleTree tree(mesh);
    const Vector3d beyond(0.05 * count + 2, 0.025, 0);
    EXPECT_NEAR(tree.nearest(beyond).squared_distance, 4, 1e-5) << count;
  }
  EXPECT_THAT(error_of([] { TriangleTree tree{Mesh{}}; }), HasSubstr("no triangles"));
}

TEST(SampleSurface, IsUniformInArea) {
  // Two triangles of area 1.5 and 0.5 next to each other.
  Mesh mesh;
  mesh.vertices = {{0, 0, 0}, {3, 0, 0}, {0, 1, 0}, {-1, 0, 0}};
  mesh.triangles = {{0, 1, 2}, {3, 0, 2}};
  const auto points = sample_surface(mesh, 40'000);
  const auto right = std::count_if(points.begin(), points.end(), [](const Vector3d& p) { return p.x() > 0; });
  EXPECT_NEAR(static_cast<double>(right) / 40'000, 0.75, 1e-3);
  Vector3d mean = Vector3d::Zero();
  for (const Vector3d& p : points) mean += p / 40'000;
  EXPECT_LT((mean - Vector3d(0.75 * 1 + 0.25 * (-1.0 / 3), 1.0 / 3, 0)).norm(),
            0.01);  // the weighted centroids
  Mesh flat;
  flat.vertices = {{0, 0, 0}, {1, 0, 0}};
  flat.triangles = {{0, 1, 1}};
  EXPECT_THAT(error_of([&] { sample_surface(flat, 10); }), HasSubstr("no area"));
}

TEST(SurfaceError, AnOffsetWallIsOffByTheOffset) {
  const Mesh truth = wall(20, 20, 0, 0), map = wall(20, 20, 0, 0.015f);
  const SurfaceError error = surface_error(map, truth, truth, Pose::Identity(), kQuick);
  EXPECT_NEAR(error.accuracy_m.mean, 0.015, 1e-7);
  EXPECT_NEAR(error.accuracy_m.rmse, 0.015, 1e-7);
  EXPECT_NEAR(error.accuracy_m.p95, 0.015, 1e-7);
  EXPECT_NEAR(error.completeness_m.median, 0.015, 1e-7);
  EXPECT_EQ(error.accurate_share, 1);
  EXPECT_EQ(error.complete_share, 1);
  EXPECT_EQ(error.f_score, 1);
}

TEST(SurfaceError, ALargerSphereIsOffByTheDifference) {
  const SurfaceError error =
      surface_error(sphere(1.03, 200), sphere(1, 200), sphere(1, 200), Pose::Identity(), kQuick);
  EXPECT_NEAR(error.accuracy_m.mean, 0.03, 1e-4);
  EXPECT_NEAR(error.completeness_m.mean, 0.03, 1e-4);
  EXPECT_EQ(error.accurate_share, 0);
  EXPECT_EQ(error.f_score, 0);
}

TEST(SurfaceError, AMissingHalfCostsCompletenessNotAccuracy) {
  const Mesh truth = wall(40, 10, 0, 0), map = wall(20, 10, 0, 0);
  const SurfaceError error = surface_error(map, truth, truth, Pose::Identity(), kQuick);
  EXPECT_LT(error.accuracy_m.max, 1e-6);
  EXPECT_EQ(error.accurate_share, 1);
  EXPECT_NEAR(error.complete_share, 0.5 + 0.02 / 2, 1e-3);  // the threshold reaches 2 cm into the other half
  EXPECT_NEAR(error.f_score, 2 * 0.51 / 1.51, 1e-3);
  EXPECT_NEAR(error.completeness_m.mean, 0.25, 1e-3);  // distances from 0 to 1 m over half of the area
}

TEST(SurfaceError, CompletenessIsAskedOfTheSeenPartOnly) {
  const Mesh truth = wall(40, 10, 0, 0), seen = wall(20, 10, 0, 0), map = wall(20, 10, 0, 0);
  EXPECT_EQ(surface_error(map, truth, seen, Pose::Identity(), kQuick).complete_share, 1);
  // What was mapped beyond the seen part is still compared with the whole truth.
  EXPECT_EQ(surface_error(truth, truth, seen, Pose::Identity(), kQuick).accurate_share, 1);
}

TEST(SurfaceError, TheAlignmentPlacesTheMap) {
  const Pose T_groundtruth_map = exp_se3((Vector6d() << 0.3, -0.2, 0.5, 1, 2, 3).finished());
  const Mesh truth = sphere(1, 60);
  Mesh map = truth;
  for (Vec3f& p : map.vertices) {
    const Vector3d q = T_groundtruth_map.inverse() * Vector3d(p.x, p.y, p.z);
    p = {static_cast<float>(q.x()), static_cast<float>(q.y()), static_cast<float>(q.z())};
  }
  EXPECT_LT(surface_error(map, truth, truth, T_groundtruth_map, kQuick).accuracy_m.max, 1e-6);
}

TEST(SurfaceError, DoesNotDependOnTheNumberOfThreads) {
  const Mesh map = sphere(1.01, 150), truth = sphere(1, 90);
  std::vector<std::vector<double>> distances;
  for (const int threads : {1, 2, 5}) {
    SurfaceErrorOptions options = kQuick;
    options.threads = threads;
    const SurfaceError error = surface_error(map, truth, truth, Pose::Identity(), options);
    distances.push_back(error.accuracy_distances_m);
    distances.back().insert(distances.back().end(), error.completeness_distances_m.begin(),
                            error.completeness_distances_m.end());
  }
  EXPECT_EQ(distances[0], distances[1]);
  EXPECT_EQ(distances[0], distances[2]);
}

}  // namespace
}  // namespace kt
