// Tests of simplifying: shape, borders, colours and how the surface hangs together are kept.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/map/simplify.h"

#include <gtest/gtest.h>
#include <map>
#include <set>

#include "offboard/map/quadric.h"
#include "shared/io/ply.h"
#include "tests/offboard/map/made_sheets.h"
#include "tests/offboard/map/mesh_area.h"

namespace kt::test {
namespace {

// An octahedron, each face split in four `levels` times and drawn out to a sphere of 1 m.
Mesh made_sphere(int levels) {
  Mesh mesh;
  mesh.vertices = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  mesh.triangles = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  for (int level = 0; level < levels; ++level) {
    std::map<std::pair<uint32_t, uint32_t>, uint32_t> middles;
    const auto middle = [&](uint32_t a, uint32_t b) {
      const auto [at, is_new] =
          middles.emplace(std::minmax(a, b), static_cast<uint32_t>(mesh.vertices.size()));
      const Vec3f p = mesh.vertices[a] + mesh.vertices[b];
      if (is_new) mesh.vertices.push_back((1 / norm(p)) * p);
      return at->second;
    };
    std::vector<std::array<uint32_t, 3>> finer;
    for (const auto& [a, b, c] : mesh.triangles) {
      const uint32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      for (const auto& triangle : {std::array{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}})
        finer.push_back(triangle);
    }
    mesh.triangles = finer;
  }
  mesh.normals = mesh.vertices;
  return mesh;
}

std::map<std::pair<uint32_t, uint32_t>, int> uses_of_edges(const Mesh& mesh) {
  std::map<std::pair<uint32_t, uint32_t>, int> uses;
  for (const auto& t : mesh.triangles) {
    for (size_t k = 0; k < 3; ++k) ++uses[std::minmax(t[k], t[(k + 1) % 3])];
  }
  return uses;
}

std::set<std::array<float, 3>> border_of(const Mesh& mesh) {
  std::set<std::array<float, 3>> points;
  for (const auto& [edge, count] : uses_of_edges(mesh)) {
    if (count != 1) continue;
    for (const uint32_t v : {edge.first, edge.second})
      points.insert({mesh.vertices[v].x, mesh.vertices[v].y, mesh.vertices[v].z});
  }
  return points;
}

TEST(Quadric, IsTheWeightedSumOfSquaredDistancesAndLeastWherePlanesMeet) {
  Quadric sum({1, 0, 0}, -2, 0.5);  // x = 2
  sum += Quadric({0, 0.6, 0.8}, -1, 3);
  EXPECT_NEAR(sum({5, 1, 2}), 0.5 * 9 + 3 * 1.2 * 1.2, 1e-12);
  EXPECT_EQ(sum.weight(), 3.5);
  const Point least = sum.least_near({2.1, 0.6, 0.7});
  EXPECT_NEAR(least[0], 2, 1e-3);
  EXPECT_LT(sum(least), 1e-8);
  sum += Quadric({0, 0.8, -0.6}, 0, 2);
  EXPECT_NEAR(sum.least_near({2, 0.6, 0.8})[1], 0.6, 1e-9);
  EXPECT_EQ(Quadric().least_near({1, 2, 3}), (Point{1, 2, 3}));
}

TEST(Simplify, AFlatSheetKeepsItsBorderItsAreaAndItsPlane) {
  const Mesh before = made_sheet(0, 30, 0.5f, 3);
  Mesh mesh = before;
  const SimplifyReport report = simplify({.keep_share = 0, .max_error_m = 1e-5}, mesh);
  EXPECT_LT(report.largest_error_m, 1e-6);
  EXPECT_LT(mesh.vertices.size(), 110u);  // 100 stand along the border
  EXPECT_EQ(static_cast<int64_t>(before.triangles.size() - mesh.triangles.size()),
            2 * report.collapsed_edges);
  EXPECT_EQ(border_of(mesh), border_of(before));
  EXPECT_NEAR(area_m2(mesh), area_m2(before), 1e-6);
  for (const Vec3f p : mesh.vertices) EXPECT_NEAR(p.z, 0.5f, 1e-6f);
  for (double x = 0.0013; x < 0.3; x += 0.0131) {
    for (double y = 0.0017; y < 0.2; y += 0.0137) EXPECT_EQ(layers_at(mesh, x, y), 1);
  }
}

TEST(Simplify, ASphereStaysClosedAndRound) {
  const Mesh before = made_sphere(4);
  Mesh mesh = before;
  const SimplifyReport report = simplify({.keep_share = 0.1}, mesh);
  EXPECT_EQ(mesh.triangles.size(), before.triangles.size() / 10 - before.triangles.size() / 10 % 2);
  EXPECT_LT(report.largest_error_m, 0.02);
  for (const Vec3f p : mesh.vertices) EXPECT_NEAR(norm(p), 1, 0.02f);
  EXPECT_GT(area_m2(mesh), 0.96 * area_m2(before));
  const auto edges = uses_of_edges(mesh);
  for (const auto& [edge, count] : edges) EXPECT_EQ(count, 2);
  EXPECT_EQ(mesh.vertices.size() + mesh.triangles.size(), edges.size() + 2);  // Euler
  for (const auto& [a, b, c] : mesh.triangles) {
    const Vec3f normal = cross(mesh.vertices[b] - mesh.vertices[a], mesh.vertices[c] - mesh.vertices[a]);
    EXPECT_GT(dot(normal, mesh.vertices[a]), 0);
  }
}

TEST(Simplify, AnEdgeOfTheSurfaceStaysSharp) {
  Mesh mesh = made_sheet(-15, 15, 0, 1);
  for (Vec3f& p : mesh.vertices) p.z = -std::abs(p.x);  // a roof
  const size_t before = mesh.triangles.size();
  simplify({.keep_share = 0, .max_error_m = 1e-4}, mesh);
  EXPECT_LT(mesh.triangles.size(), before / 4);
  for (const Vec3f p : mesh.vertices) EXPECT_NEAR(p.z, -std::abs(p.x), 1e-3f);
  for (const auto& [a, b, c] : mesh.triangles) {
    const Vec3f p = (1.0f / 3) * (mesh.vertices[a] + mesh.vertices[b] + mesh.vertices[c]);
    EXPECT_NEAR(p.z, -std::abs(p.x), 1e-3f);
  }
}

TEST(Simplify, ColoursAndWeightsStayWhereTheyWere) {
  Mesh mesh = made_sheet(0, 30, 0, 1);
  const auto red = [](Vec3f p) { return 20 + 700 * p.x; };
  for (size_t i = 0; i < mesh.vertices.size(); ++i) {
    mesh.colours[i] = {static_cast<uint8_t>(red(mesh.vertices[i])), 7, 9};
    mesh.quality[i] = mesh.vertices[i].y;
  }
  simplify({.keep_share = 0.3}, mesh);
  for (size_t i = 0; i < mesh.vertices.size(); ++i) {
    EXPECT_NEAR(mesh.colours[i].r, red(mesh.vertices[i]), 4);
    EXPECT_EQ(mesh.colours[i].g, 7);
    EXPECT_NEAR(mesh.quality[i], mesh.vertices[i].y, 0.005f);
    EXPECT_EQ(norm(mesh.normals[i]), 1);
  }
}

TEST(Simplify, NothingAboveTheErrorFallsAndEqualMeshesGiveEqualBytes) {
  Mesh mesh = made_sphere(3);
  simplify({.keep_share = 0, .max_error_m = 1e-6}, mesh);
  EXPECT_EQ(ply_bytes(mesh), ply_bytes(made_sphere(3)));
  Mesh again = mesh;
  EXPECT_LE(simplify({.keep_share = 0, .max_error_m = 0.02}, mesh).largest_error_m, 0.02);
  simplify({.keep_share = 0, .max_error_m = 0.02}, again);
  EXPECT_LT(mesh.triangles.size(), made_sphere(3).triangles.size() / 2);
  EXPECT_EQ(ply_bytes(mesh), ply_bytes(again));
  Mesh nothing;
  EXPECT_EQ(simplify({}, nothing).collapsed_edges, 0);
}

}  // namespace
}  // namespace kt::test
