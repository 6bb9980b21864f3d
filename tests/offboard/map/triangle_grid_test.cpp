// Tests of finding the triangles that a line crosses, against trying all of them.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/map/triangle_grid.h"

#include <gtest/gtest.h>
#include <set>

#include "offboard/map/mesh_parts.h"
#include "tests/offboard/map/made_sheets.h"

namespace kt::test {
namespace {

std::set<uint32_t> crossed(const TriangleGrid& grid, Vec3f a, Vec3f b) {
  std::set<uint32_t> found;
  grid.any_crossed(a, b, [&](uint32_t triangle, double) {
    found.insert(triangle);
    return false;
  });
  return found;
}

TEST(TriangleGrid, FindsWhatAGridOfOneCellFinds) {
  const Mesh mesh = concatenated(
      std::vector{turned(made_sheet(-15, 15, 0.02f, 1), 20), turned(made_sheet(-9, 9, -0.03f, 1), 120)});
  const TriangleGrid fine(mesh, 0.013), whole(mesh, 100);
  size_t hits = 0;
  for (int i = 0; i < 2000; ++i) {
    const auto random = [i](uint32_t k) {
      const uint32_t hash = (static_cast<uint32_t>(i) * 6 + k) * 2654435761u;
      return static_cast<float>(hash >> 8) / static_cast<float>(1 << 24) * 0.3f - 0.15f;
    };
    const Vec3f a{random(0), random(1) + 0.1f, random(2)};
    const Vec3f b = a + 0.5f * Vec3f{random(3), random(4), random(5)};
    const std::set<uint32_t> expected = crossed(whole, a, b);
    EXPECT_EQ(crossed(fine, a, b), expected);
    hits += expected.size();
  }
  EXPECT_GT(hits, 20u);
}

TEST(TriangleGrid, TellsWhereALineCrossesAndStopsAtTheFirstThatIsAccepted) {
  const Mesh mesh = concatenated(std::vector{made_sheet(0, 3, 0.25f, 1), made_sheet(0, 3, 0.5f, 1)});
  const TriangleGrid grid(mesh, 0.1);
  int asked = 0;
  EXPECT_TRUE(grid.any_crossed({0.013f, 0.034f, 0}, {0.013f, 0.034f, 1}, [&](uint32_t, double t) {
    ++asked;
    EXPECT_TRUE(std::abs(t - 0.25) < 1e-6 || std::abs(t - 0.5) < 1e-6) << t;
    return true;
  }));
  EXPECT_EQ(asked, 1);
  EXPECT_TRUE(crossed(grid, {0.013f, 0.034f, 0.3f}, {0.013f, 0.034f, 0.4f}).empty());
}

TEST(TriangleGrid, ALineThroughAnEdgeOrAVertexSlipsThroughNowhere) {
  const Mesh mesh = made_sheet(0, 3, 0, 1);
  const TriangleGrid of_mesh(mesh, 0.03);
  for (const Vec3f p : mesh.vertices)
    EXPECT_FALSE(crossed(of_mesh, p - Vec3f{0, 0, 0.02f}, p + Vec3f{0, 0, 0.02f}).empty());
}

TEST(TriangleGrid, ATriangleOfTheSizeOfARoomCostsNoMoreThanOthers) {
  Mesh mesh = made_sheet(0, 3, 0, 1);
  mesh.vertices.insert(mesh.vertices.end(), {{-1e4f, -1e4f, -1e4f}, {1e4f, -1e4f, 1e4f}, {0, 1e4f, 0}});
  const auto last = static_cast<uint32_t>(mesh.vertices.size());
  mesh.triangles.push_back({last - 3, last - 2, last - 1});
  const TriangleGrid grid(mesh, 0.03);
  EXPECT_EQ(crossed(grid, {5, 5, 4}, {5, 5, 6}),
            (std::set<uint32_t>{static_cast<uint32_t>(mesh.triangles.size()) - 1}));
}

}  // namespace
}  // namespace kt::test
