// The rasteriser against pictures known in closed form.
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/render/rasteriser.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <numbers>
#include <utility>
#include <vector>

#include "shared/core/check.h"

namespace kt {
namespace {

constexpr Rgb8 kBackground{9, 9, 9};
/// 64 x 48 pixels; the view frame is the map frame.
Viewpoint test_view(bool is_orthographic, float scale) {
  Viewpoint view;
  view.is_orthographic = is_orthographic;
  view.scale = scale;
  view.width = 64;
  view.height = 48;
  view.cx = 31.5f;
  view.cy = 23.5f;
  return view;
}

Mesh make_mesh(std::vector<Vec3f> vertices, std::vector<Rgb8> colours,
               std::vector<std::array<uint32_t, 3>> triangles) {
  Mesh mesh;
  mesh.vertices = std::move(vertices);
  mesh.colours = std::move(colours);
  mesh.triangles = std::move(triangles);
  return mesh;
}

/// The rectangle [x0, x1] x [y0, y1] at depth z, which faces a viewer who looks along z.
Mesh rectangle(float x0, float x1, float y0, float y1, float z, Rgb8 colour) {
  // Seen along +z with y down, (x0, y0) -> (x0, y1) -> (x1, y1) runs counter-clockwise.
  return make_mesh({{x0, y0, z}, {x0, y1, z}, {x1, y1, z}, {x1, y0, z}}, std::vector<Rgb8>(4, colour),
                   {{0, 1, 2}, {0, 2, 3}});
}

int64_t count(const Image<Rgb8>& image, Rgb8 colour) {
  return std::count(image.pixels().begin(), image.pixels().end(), colour);
}

TEST(Canvas, RectangleCoversExactlyItsPixels) {
  // Perspective with scale 40: x in [-1, 0.5] at z = 2 covers u in [11.5, 41.5], y in [-0.25, 0.75] v in
  // [18.5, 38.5].
  Canvas canvas(test_view(false, 40), kBackground);
  canvas.draw(rectangle(-1, 0.5f, -0.25f, 0.75f, 2, {200, 100, 50}));
  for (int v = 0; v < 48; ++v)
    for (int u = 0; u < 64; ++u) {
      const bool inside = u >= 12 && u <= 41 && v >= 19 && v <= 38;
      ASSERT_EQ(canvas.colour()(u, v), inside ? (Rgb8{200, 100, 50}) : kBackground) << u << " " << v;
      ASSERT_EQ(std::isinf(canvas.depth()(u, v)), !inside) << u << " " << v;
      ASSERT_NEAR(inside ? canvas.depth()(u, v) : 2, 2, 1e-5);
    }
}

TEST(Canvas, TrianglesThatTurnTheirBackAreLeftOut) {
  Mesh mesh = rectangle(-1, 1, -1, 1, 2, {1, 2, 3});
  for (auto& t : mesh.triangles) std::swap(t[0], t[1]);
  Canvas canvas(test_view(false, 40), kBackground);
  canvas.draw(mesh);
  EXPECT_EQ(count(canvas.colour(), kBackground), 64 * 48);
}

TEST(Canvas, TheNearerSurfaceWinsInEitherOrder) {
  const Mesh near = rectangle(-0.2f, 0.2f, -0.2f, 0.2f, 1, {255, 0, 0});
  const Mesh far = rectangle(-2, 2, -2, 2, 3, {0, 0, 255});
  Canvas near_first(test_view(false, 40), kBackground), far_first(test_view(false, 40), kBackground);
  near_first.draw(near);
  near_first.draw(far);
  far_first.draw(far);
  far_first.draw(near);
  EXPECT_EQ(near_first.colour(), far_first.colour());
  EXPECT_EQ(near_first.colour()(32, 24), (Rgb8{255, 0, 0}));
  // At z = 1 the small one covers u in [23.5, 39.5] and v in [15.5, 31.5].
  EXPECT_EQ(count(near_first.colour(), {255, 0, 0}), 16 * 16);
}

TEST(Canvas, DepthAndColourFollowAPlaneInPerspective) {
  // The plane z = 2 + x, colour linear in x: along the ray of u, z = 2 / (1 - t) with t = (u - cx) / scale.
  Mesh mesh = make_mesh({{-1, -2, 1}, {-1, 2, 1}, {1, 2, 3}, {1, -2, 3}}, {}, {{0, 1, 2}, {0, 2, 3}});
  for (const Vec3f& p : mesh.vertices) mesh.colours.push_back({static_cast<uint8_t>(100 * (p.x + 1)), 0, 0});
  Canvas canvas(test_view(false, 40), kBackground);
  canvas.draw(mesh);
  int covered = 0;
  for (int u = 0; u < 64; ++u) {
    const double t = (u - 31.5) / 40, z = 2 / (1 - t), x = z - 2;
    if (x <= -1 || x >= 1) continue;
    ++covered;
    ASSERT_NEAR(canvas.depth()(u, 24), z, 1e-4) << u;
    ASSERT_NEAR(canvas.colour()(u, 24).r, 100 * (x + 1), 0.51) << u;
  }
  EXPECT_GT(covered, 20);
}

TEST(Canvas, OrthographicViewDoesNotShrinkWithDistance) {
  for (const float z : {1.0f, 7.0f}) {
    Canvas canvas(test_view(true, 10), kBackground);
    canvas.draw(rectangle(-1, 1, -1, 1, z, {0, 255, 0}));
    EXPECT_EQ(count(canvas.colour(), {0, 255, 0}), 20 * 20);
    EXPECT_NEAR(canvas.depth()(32, 24), z, 1e-5);
  }
}

TEST(Canvas, SphereHasItsSilhouetteAndDepth) {
  // A latitude-longitude sphere; inscribed facets lie at most 1 - cos(pi / 128) of the radius inside.
  const Vec3f centre{0.3f, -0.2f, 4};
  Mesh mesh;
  constexpr int kRows = 128, kColumns = 256;
  for (int i = 0; i <= kRows; ++i)
    for (int j = 0; j < kColumns; ++j) {
      const double a = std::numbers::pi * i / kRows, b = 2 * std::numbers::pi * j / kColumns;
      const Vec3f n{static_cast<float>(std::sin(a) * std::cos(b)),
                    static_cast<float>(std::sin(a) * std::sin(b)), static_cast<float>(std::cos(a))};
      mesh.vertices.push_back(centre + n);
      mesh.colours.push_back({255, 255, 255});
    }
  const auto at = [](int i, int j) { return static_cast<uint32_t>(i * kColumns + j % kColumns); };
  for (int i = 0; i < kRows; ++i)
    for (int j = 0; j < kColumns; ++j) {
      mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  const Viewpoint view = test_view(true, 16);
  Canvas canvas(view, kBackground);
  canvas.draw(mesh);
  for (int v = 0; v < 48; ++v)
    for (int u = 0; u < 64; ++u) {
      const double x = (u - 31.5) / 16 - 0.3, y = (v - 23.5) / 16 + 0.2, r2 = x * x + y * y;
      if (r2 < 0.98) {
        ASSERT_NEAR(canvas.depth()(u, v), 4 - std::sqrt(1 - r2), 3e-3) << u << " " << v;
      }
      if (r2 > 1.0) {
        ASSERT_EQ(canvas.colour()(u, v), kBackground) << u << " " << v;
      }
    }
}

TEST(Canvas, ATriangleThroughTheViewerIsCut) {
  // A floor 1 m below that reaches from 4 m behind to 4 m ahead: it is seen from v = cy + scale / 4 down.
  const Mesh floor = make_mesh({{-50, 1, -4}, {50, 1, -4}, {50, 1, 4}, {-50, 1, 4}},
                               std::vector<Rgb8>(4, Rgb8{7, 7, 7}), {{0, 1, 2}, {0, 2, 3}});
  Canvas canvas(test_view(false, 40), kBackground);
  canvas.draw(floor);
  for (int v = 0; v < 48; ++v)
    EXPECT_EQ(canvas.colour()(20, v), v > 33.5 ? (Rgb8{7, 7, 7}) : kBackground) << v;
}

TEST(Canvas, CornersOutsideTheMeshAreABug) {
  Mesh mesh = rectangle(-1, 1, -1, 1, 2, {1, 1, 1});
  mesh.triangles.push_back({0, 1, 99});
  Canvas canvas(test_view(false, 40), kBackground);
  EXPECT_THROW(canvas.draw(mesh), LogicError);
}

TEST(Canvas, PathIsALineThatHidesBehindSurfaces) {
  const std::array<Vec3f, 2> path{Vec3f{-0.5f, 0, 2}, Vec3f{0.5f, 0, 2}};
  Canvas canvas(test_view(false, 40), kBackground);
  canvas.draw(rectangle(0, 1, -1, 1, 1.5f, {1, 1, 1}));
  canvas.draw_path(path, {255, 200, 0}, 2);
  // From u = 21.5 to the wall that starts at 31.5, two pixels wide around v = 23.5, with round ends.
  for (int u = 22; u <= 31; ++u)
    for (int v = 0; v < 48; ++v)
      ASSERT_EQ(canvas.colour()(u, v) == (Rgb8{255, 200, 0}), v == 23 || v == 24) << u << " " << v;
  EXPECT_EQ(canvas.colour()(33, 23), (Rgb8{1, 1, 1}));
}

TEST(Canvas, DepthEdgesDarkenTheFartherSideOnly) {
  Canvas canvas(test_view(true, 10), kBackground);
  canvas.draw(rectangle(-2, 2, -2, 2, 4, {200, 200, 200}));
  canvas.draw(rectangle(-1, 1, -1, 1, 2, {200, 200, 200}));
  canvas.shade_depth_edges(1, 8);
  EXPECT_EQ(canvas.colour()(32, 24), (Rgb8{200, 200, 200}));  // flat
  EXPECT_EQ(canvas.colour()(22, 24), (Rgb8{200, 200, 200}));  // edge of the nearer one
  // Three of the eight neighbours are nearer by log2(2), each limited to 0.1: exp(-8 * 0.3 / 8) = 0.7408.
  EXPECT_EQ(canvas.colour()(21, 24), (Rgb8{148, 148, 148}));
  EXPECT_EQ(canvas.colour()(0, 0), kBackground);
}

TEST(Canvas, MeshWithoutColoursIsGrey) {
  Mesh mesh = rectangle(-1, 1, -1, 1, 2, {});
  mesh.colours.clear();
  Canvas canvas(test_view(false, 40), kBackground);
  canvas.draw(mesh);
  const Rgb8 c = canvas.colour()(32, 24);
  EXPECT_TRUE(c.r == c.g && c.g == c.b && c.r > 100);
}

TEST(Light, FollowsLambertsLaw) {
  const Vec3f light_map{-0.40f, -0.48f, -0.78f}, across{0.78f, 0, -0.40f};
  Mesh mesh = make_mesh(std::vector<Vec3f>(4), std::vector<Rgb8>(4, Rgb8{100, 50, 0}), {});
  mesh.normals = {light_map, -light_map, across, {0, 0, -1}};
  light(mesh, test_view(false, 40));
  EXPECT_NEAR(mesh.colours[0].r, 115, 1);
  EXPECT_NEAR(mesh.colours[0].g, 58, 1);
  EXPECT_EQ(mesh.colours[1], (Rgb8{72, 36, 0}));  // turned away: the even share alone
  EXPECT_EQ(mesh.colours[2], (Rgb8{72, 36, 0}));
  EXPECT_NEAR(mesh.colours[3].r, 72 + 43 * 0.78, 1);
}

TEST(Light, TakesTheTrianglesNormalsWhereTheMeshHasNone) {
  Mesh without = rectangle(-1, 1, -1, 1, 2, {100, 100, 100});  // faces -z
  Mesh with = without;
  with.normals.assign(4, Vec3f{0, 0, -1});
  light(without, test_view(false, 40));
  light(with, test_view(false, 40));
  EXPECT_EQ(without.colours, with.colours);
}

TEST(Shrunk, TakesTheRoundedMeanOfEachBlock) {
  Image<Rgb8> image(4, 2);
  image(0, 0) = {10, 0, 255};
  image(1, 0) = {20, 0, 255};
  image(0, 1) = {30, 1, 255};
  image(1, 1) = {41, 1, 255};
  image(2, 0) = {4, 4, 4};
  const Image<Rgb8> small = shrunk(image, 2);
  EXPECT_EQ(small.width(), 2);
  EXPECT_EQ(small.height(), 1);
  EXPECT_EQ(small(0, 0), (Rgb8{25, 1, 255}));  // 101 / 4 = 25.25, 2 / 4 rounds up
  EXPECT_EQ(small(1, 0), (Rgb8{1, 1, 1}));
}

}  // namespace
}  // namespace kt
