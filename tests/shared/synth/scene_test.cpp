// Ray casting, distances and light of whole scenes.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/synth/scene.h"

#include <gtest/gtest.h>

#include "shared/core/check.h"
#include "shared/synth/furniture.h"
#include "shared/synth/world.h"

namespace kt {
namespace {

using Eigen::Vector3d;

TEST(Scene, CastFindsTheNearestOfSeveralAndDescribesIt) {
  Scene scene;
  scene.add({ShapeKind::kBox, {0.5, 0.5, 0.5}}, place(0, 3, 0, 1), {});
  scene.add({ShapeKind::kSphere, {0.5, 0, 0}}, place(0, 2, 0, 1), {});
  const auto hit = scene.cast({0, 0, 0}, {0, 2, 0});
  ASSERT_TRUE(hit);
  EXPECT_EQ(hit->primitive, 1);
  EXPECT_NEAR(hit->distance, 0.75, 1e-12);  // 1.5 m in lengths of the direction vector
  EXPECT_LT((hit->p_world - Vector3d(0, 1.5, 0)).norm(), 1e-12);
  EXPECT_LT((hit->n_world - Vector3d(0, -1, 0)).norm(), 1e-12);
  EXPECT_FALSE(scene.cast({0, 0, 0}, {1, 0, 0}));
}

TEST(Scene, NormalOfABoxSeenFromInsideFacesTheRay) {
  Scene scene;
  scene.add({ShapeKind::kBox, {2, 2, 1}}, Pose::Identity(), {});
  const auto hit = scene.cast({0.5, 0.2, 0}, {1, 0, 0});
  ASSERT_TRUE(hit);
  EXPECT_NEAR(hit->distance, 1.5, 1e-12);
  EXPECT_LT((hit->n_world - Vector3d(-1, 0, 0)).norm(), 1e-12);
}

TEST(Scene, PlacedPiecesKeepHandednessAndFaceTheirDirection) {
  const Pose T = place(1, 2, -0.3, 0.4, 0.5);
  EXPECT_TRUE(is_valid_pose(T, 1e-12));
  EXPECT_LT((T.linear().col(1) - Vector3d(-0.6, 0.8, 0)).norm(), 1e-12);
  EXPECT_LT((T.translation() - Vector3d(1, 2, 0.5)).norm(), 1e-12);
}

TEST(Scene, DistanceToSurfaceIsTheSmallestOverAllPieces) {
  Scene scene;
  EXPECT_EQ(scene.distance_to_surface({0, 0, 0}), std::numeric_limits<double>::infinity());
  scene.add({ShapeKind::kBox, {0.5, 0.5, 0.5}}, place(0, 3, 1, 1), {});
  scene.add({ShapeKind::kSphere, {0.5, 0, 0}}, place(2, 0, 0, 1), {});
  EXPECT_NEAR(scene.distance_to_surface({0, 0, 0}), 1.5, 1e-12);
  EXPECT_NEAR(scene.distance_to_surface({0, 3, 2}), 1.5, 1e-12);
}

TEST(Scene, WallsLeaveTheirDoorsOpen) {
  Scene scene;
  Furnisher furnisher(&scene);
  add_wall(&furnisher, {0, 0}, {6, 0}, 0.1, 2.5, {1.5, 4}, {});
  const auto blocked = [&](double x, double z) { return scene.cast({x, -2, z}, {0, 1, 0}).has_value(); };
  for (const double door : {1.5, 4.0}) {
    EXPECT_FALSE(blocked(door, 1.0));
    EXPECT_FALSE(blocked(door + 0.4, 0.1));
    EXPECT_TRUE(blocked(door + 0.6, 1.0));
    EXPECT_TRUE(blocked(door, 2.2));  // lintel
  }
  EXPECT_TRUE(blocked(0.01, 1) && blocked(5.99, 1));
  EXPECT_FALSE(blocked(6.1, 1));
}

TEST(Scene, LampsLightWhatFacesThemAndNothingBeyondTheirReach) {
  Scene dark, lit;
  lit.add_light({{0, 0, 2}, 3, 1});
  const Vector3d up(0, 0, 1);
  EXPECT_GT(lit.irradiance({0, 0, 0}, up), dark.irradiance({0, 0, 0}, up) + 0.2f);
  EXPECT_GT(lit.irradiance({0, 0, 0}, up), lit.irradiance({1, 0, 0}, up));
  EXPECT_EQ(lit.irradiance({0, 0, 0}, -up), dark.irradiance({0, 0, 0}, -up));
  EXPECT_EQ(lit.irradiance({0, 0, -1.01}, up), dark.irradiance({0, 0, -1.01}, up));
}

TEST(Scene, RefusesShapesOfNoSize) {
  Scene scene;
  EXPECT_THROW(scene.add({ShapeKind::kBox, {0.5, 0, 0.5}}, Pose::Identity(), {}), LogicError);
  EXPECT_THROW(scene.add({ShapeKind::kSphere, {0, 0, 0}}, Pose::Identity(), {}), LogicError);
}

}  // namespace
}  // namespace kt
