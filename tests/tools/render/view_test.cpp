// The choice of a view: everything in the picture, the right way up, unmoved by stray points.
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/render/view.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <vector>

#include "shared/core/check.h"
#include "shared/core/rng.h"

namespace kt {
namespace {

struct Pixel {
  float u, v;
};

Pixel project(const Viewpoint& view, Vec3f p_map) {
  const Vec3f p = view.T_view_map * p_map;
  const float q = view.is_orthographic ? 1 : 1 / p.z;
  return {view.cx + view.scale * p.x * q, view.cy + view.scale * p.y * q};
}

/// Corners of a box of 6 x 2.5 x 4 m (y is up or down), off the origin.
std::vector<Vec3f> box_corners() {
  std::vector<Vec3f> corners;
  for (int k = 0; k < 8; ++k)
    corners.push_back({k & 1 ? 7.0f : 1.0f, k & 2 ? 1.0f : -1.5f, k & 4 ? 2.0f : -2.0f});
  return corners;
}

TEST(FramePoints, HoldsEveryCornerAndFillsThePicture) {
  for (const char* name : {"iso", "top"})
    for (const char* up : {"x", "-x", "y", "-y", "z", "-z"}) {
      ViewOptions options;
      options.name = name;
      options.up_map = axis_from_text(up);
      options.width = 400;
      options.height = 300;
      const Viewpoint view = frame_points(box_corners(), options);
      float left = 1e9f, right = -1e9f, top = 1e9f, bottom = -1e9f;
      for (const Vec3f p : box_corners()) {
        const Pixel px = project(view, p);
        left = std::min(left, px.u), right = std::max(right, px.u);
        top = std::min(top, px.v), bottom = std::max(bottom, px.v);
        EXPECT_GT((view.T_view_map * p).z, 0);
      }
      EXPECT_GE(left, 0) << name << up;
      EXPECT_LE(right, 399) << name << up;
      EXPECT_GE(top, 0) << name << up;
      EXPECT_LE(bottom, 299) << name << up;
      EXPECT_TRUE(right - left > 330 || bottom - top > 240) << name << up;
    }
}

TEST(FramePoints, ShowsUpAsUp) {
  for (const char* up : {"x", "-x", "y", "-y", "z", "-z"})
    for (const char* name : {"iso", "inside"}) {
      ViewOptions options;
      options.name = name;
      options.up_map = axis_from_text(up);
      const Viewpoint view = frame_points(box_corners(), options);
      const Vec3f up_view = view.T_view_map.R * options.up_map;
      EXPECT_NEAR(up_view.x, 0, 1e-6) << name << up;
      EXPECT_LT(up_view.y, -0.5) << name << up;  // the picture's v points down
    }
}

TEST(FramePoints, IsoLooksDownByTheElevationAndTurnsByTheAzimuth) {
  ViewOptions options;
  options.azimuth_deg = 0;
  options.elevation_deg = 30;
  const Mat3f R = frame_points(box_corners(), options).T_view_map.R;
  EXPECT_NEAR(R.m[6], 0, 1e-6);    // looks along the first camera's z ...
  EXPECT_NEAR(R.m[7], 0.5, 1e-6);  // ... and down (its y) by 30 degrees
  EXPECT_NEAR(R.m[8], std::sqrt(0.75), 1e-6);
  options.azimuth_deg = 90;
  const Mat3f turned = frame_points(box_corners(), options).T_view_map.R;
  EXPECT_NEAR(turned.m[8], 0, 1e-6);
  EXPECT_NEAR(std::abs(turned.m[6]), std::sqrt(0.75), 1e-6);
}

TEST(FramePoints, RotationsAreProper) {
  for (const char* name : {"iso", "top", "inside"}) {
    ViewOptions options;
    options.name = name;
    const auto& m = frame_points(box_corners(), options).T_view_map.R.m;
    const Vec3f x{m[0], m[1], m[2]}, y{m[3], m[4], m[5]}, z{m[6], m[7], m[8]};
    EXPECT_NEAR(norm(cross(x, y) - z), 0, 1e-6) << name;  // also the handedness: pictures are not mirrored
    EXPECT_NEAR(norm(x), 1, 1e-6) << name;
  }
}

TEST(FramePoints, StrayPointsDoNotShrinkTheMap) {
  std::vector<Vec3f> points;
  for (uint64_t i = 0; i < 20000; ++i)
    points.push_back({static_cast<float>(6 * random_uniform(1, 0, i)),
                      static_cast<float>(2 * random_uniform(1, 1, i)),
                      static_cast<float>(4 * random_uniform(1, 2, i))});
  for (const char* name : {"iso", "top"}) {
    ViewOptions options;
    options.name = name;
    const Viewpoint clean = frame_points(points, options);
    std::vector<Vec3f> with_stray = points;
    for (int i = 0; i < 5; ++i) with_stray.push_back({-300.0f - static_cast<float>(i), 50, 900});
    const Viewpoint view = frame_points(with_stray, options);
    EXPECT_NEAR(norm(view.T_view_map.t - clean.T_view_map.t), 0, 0.1) << name;
    EXPECT_NEAR(view.scale / clean.scale, 1, 0.01) << name;
  }
}

TEST(FramePoints, EnlargedViewSeesTheSame) {
  const Viewpoint view = frame_points(box_corners(), {});
  const Viewpoint large = view.enlarged(3);
  for (const Vec3f p : box_corners()) {
    const Pixel a = project(view, p), b = project(large, p);
    EXPECT_NEAR((a.u + 0.5f) * 3, b.u + 0.5f, 1e-2);
    EXPECT_NEAR((a.v + 0.5f) * 3, b.v + 0.5f, 1e-2);
  }
}

TEST(FramePoints, RefusesWhatItCannotShow) {
  EXPECT_THROW(frame_points({}, {}), Error);
  ViewOptions options;
  options.name = "sideways";
  EXPECT_THROW(frame_points(box_corners(), options), Error);
  options = {};
  options.width = 0;
  EXPECT_THROW(frame_points(box_corners(), options), Error);
  options = {};
  options.elevation_deg = 90;
  EXPECT_THROW(frame_points(box_corners(), options), Error);
  EXPECT_THROW(axis_from_text("up"), Error);
}

TEST(LevelledUp, TurnsToTheFloorInSpiteOfWallsAndNoise) {
  // A floor slanted by 25 degrees against the hint, walls across it, and normals every way.
  const Vec3f up{0, -std::cos(0.436f), -std::sin(0.436f)}, wall{1, 0, 0};
  std::vector<Vec3f> normals(3000, wall);
  for (uint64_t i = 0; i < 1000; ++i) {
    const auto random = [&](uint64_t stream) { return static_cast<float>(random_normal(7, stream, i)); };
    const Vec3f slanted = up + 0.03f * Vec3f{random(0), random(1), random(2)};
    const Vec3f any{random(3), random(4), random(5)};
    normals.push_back(slanted * (1 / norm(slanted)));
    normals.push_back(any * (1 / norm(any)));
  }
  EXPECT_GT(dot(levelled_up(normals, {0, -1, 0}), up), std::cos(0.01f));
}

TEST(LevelledUp, KeepsTheHintWhereNothingFacesIt) {
  const std::vector<Vec3f> normals{{1, 0, 0}, {0, 1, 0}};
  const Vec3f up = levelled_up(normals, {0, -1, 0});
  EXPECT_EQ(up.x, 0);
  EXPECT_EQ(up.y, -1);
  EXPECT_EQ(up.z, 0);
}

TEST(HeightAboveFloor, MeasuresFromTheLowestPointsWithoutStrays) {
  std::vector<Vec3f> points;
  for (int i = 0; i < 1000; ++i)
    points.push_back({0, -0.002f * static_cast<float>(i), 0});  // 0 to 2 m, y down
  points.push_back({0, 40, 0});                                 // far below
  const HeightAboveFloor height(points, {0, -1, 0});
  EXPECT_NEAR(height({5, -2, 5}), 2, 0.03);
  EXPECT_NEAR(height({5, 0, 5}), 0, 0.03);
}

}  // namespace
}  // namespace kt
