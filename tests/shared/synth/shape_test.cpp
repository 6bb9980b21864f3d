// Shapes against closed forms, and against a slow ray marcher that knows only distances.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/synth/shape.h"

#include <gtest/gtest.h>

#include "shared/core/rng.h"

namespace kt {
namespace {

using Eigen::Vector3d;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

const Shape kShapes[] = {{ShapeKind::kBox, {0.5, 0.3, 0.8}},      {ShapeKind::kQuad, {0.6, 0.4, 0}},
                         {ShapeKind::kTriangle, {0.7, 0.2, 0.5}}, {ShapeKind::kTriangle, {0.4, -0.3, 0.6}},
                         {ShapeKind::kSphere, {0.45, 0, 0}},      {ShapeKind::kCylinder, {0.3, 0, 0.5}}};

Vector3d random_point(uint64_t stream, uint64_t counter) {
  return {random_uniform(1, stream, 3 * counter) * 2 - 1, random_uniform(1, stream, 3 * counter + 1) * 2 - 1,
          random_uniform(1, stream, 3 * counter + 2) * 2 - 1};
}

TEST(Shape, PlaneSphereBoxAndCylinderAgreeWithClosedForms) {
  // Plane z = 0 from (0.1, 0.2, 2) along (0.1, 0.05, -1): t = 2.
  EXPECT_NEAR(intersect({ShapeKind::kQuad, {5, 5, 0}}, {0.1, 0.2, 2}, {0.1, 0.05, -1}), 2, 1e-12);
  // Sphere of radius 0.5, ray at impact parameter 0.3: enters at 3 - sqrt(0.5^2 - 0.3^2) = 2.6.
  EXPECT_NEAR(intersect({ShapeKind::kSphere, {0.5, 0, 0}}, {0.3, 0, -3}, {0, 0, 1}), 2.6, 1e-12);
  // From inside: leaves at + 0.4.
  EXPECT_NEAR(intersect({ShapeKind::kSphere, {0.5, 0, 0}}, {0.3, 0, 0}, {0, 0, 2}), 0.2, 1e-12);
  // Box of half extents (1, 2, 3) hit on its face x = 1, from outside and from inside.
  EXPECT_NEAR(intersect({ShapeKind::kBox, {1, 2, 3}}, {4, 0, 0}, {-1, 0.2, 0.1}), 3, 1e-12);
  EXPECT_NEAR(intersect({ShapeKind::kBox, {1, 2, 3}}, {0, 0, 0}, {1, 0.2, 0.1}), 1, 1e-12);
  // Cylinder: side at impact parameter 0.3, then the cap from above.
  EXPECT_NEAR(intersect({ShapeKind::kCylinder, {0.5, 0, 1}}, {-3, 0.3, 0}, {1, 0, 0}), 2.6, 1e-12);
  EXPECT_NEAR(intersect({ShapeKind::kCylinder, {0.5, 0, 1}}, {0.2, 0.1, 4}, {0, 0, -1}), 3, 1e-12);
}

TEST(Shape, RaysThatMissOrPointAwayHitNothing) {
  for (const Shape& shape : kShapes) {
    EXPECT_EQ(intersect(shape, {0.05, 0.05, 3}, {0.01, 0.01, 1}), kInfinity);
    EXPECT_EQ(intersect(shape, {3, 3, 3}, {1, -1, 0.1}), kInfinity);
  }
  // Parallel to a face, inside its plane and beside it.
  EXPECT_EQ(intersect({ShapeKind::kQuad, {1, 1, 0}}, {0, 0, 0.5}, {1, 0, 0}), kInfinity);
  EXPECT_EQ(intersect({ShapeKind::kBox, {1, 1, 1}}, {-3, 0, 1.5}, {1, 0, 0}), kInfinity);
  EXPECT_EQ(intersect({ShapeKind::kCylinder, {0.5, 0, 1}}, {0.6, 0, -3}, {0, 0, 1}), kInfinity);
}

TEST(Shape, FirstHitIsWhereARayMarcherStops) {
  int hits = 0, misses = 0;
  for (const Shape& shape : kShapes) {
    for (uint64_t i = 0; i < 400; ++i) {
      const Vector3d origin = 2 * random_point(1, i),
                     direction = (0.4 * random_point(2, i) - origin).normalized();
      // A step as long as the distance to the surface never crosses it.
      double t = 0;
      for (int step = 0; step < 20000 && t < 10; ++step) {
        const double distance = surface_distance(shape, origin + t * direction);
        if (distance < 1e-11) break;
        t += distance;
      }
      const double expected = t < 10 ? t : kInfinity, found = intersect(shape, origin, direction);
      (expected < kInfinity ? hits : misses) += 1;
      if (expected < kInfinity) {
        EXPECT_NEAR(found, expected, 1e-6);
      } else {
        EXPECT_EQ(found, kInfinity);
      }
    }
  }
  EXPECT_GT(hits, 800);
  EXPECT_GT(misses, 300);
}

TEST(Shape, SurfaceParametersAreInverseToEachOther) {
  for (const Shape& shape : kShapes) {
    for (int face = 0; face < face_count(shape); ++face) {
      for (uint64_t i = 0; i < 50; ++i) {
        const SurfacePoint at{face, random_uniform(2, 0, i) * 0.98 + 0.01,
                              random_uniform(2, 1, i) * 0.98 + 0.01};
        const Vector3d p = point_on(shape, at);
        EXPECT_LT(surface_distance(shape, p), 1e-12);
        const SurfacePoint back = surface_point(shape, p);
        EXPECT_EQ(back.face, face);
        EXPECT_NEAR(back.s, at.s, 1e-9);
        EXPECT_NEAR(back.t, at.t, 1e-9);
      }
    }
  }
}

TEST(Shape, NormalsHaveUnitLengthAndPointAwayFromTheSurface) {
  for (const Shape& shape : kShapes) {
    for (int face = 0; face < face_count(shape); ++face) {
      const Vector3d p = point_on(shape, {face, 0.4, 0.6}), n = outward_normal(shape, face, p);
      EXPECT_NEAR(n.norm(), 1, 1e-12);
      EXPECT_NEAR(surface_distance(shape, p + 0.05 * n), 0.05, 1e-12);
      const bool sheet = shape.kind == ShapeKind::kQuad || shape.kind == ShapeKind::kTriangle;
      if (!sheet) {
        EXPECT_GT((p + 0.05 * n).norm(), p.norm());
      }
    }
  }
}

TEST(Shape, BoundsHoldEverySurfacePointTightly) {
  for (const Shape& shape : kShapes) {
    const LocalBounds bounds = local_bounds(shape);
    Vector3d reached = Vector3d::Zero();
    for (int face = 0; face < face_count(shape); ++face) {
      for (double s = 0; s <= 1; s += 0.0625) {
        for (double t = 0; t <= 1; t += 0.0625) {
          const Vector3d offset = (point_on(shape, {face, s, t}) - bounds.centre).cwiseAbs();
          EXPECT_LE((offset - bounds.half).maxCoeff(), 1e-12);
          reached = reached.cwiseMax(offset);
        }
      }
    }
    EXPECT_LT((bounds.half - reached).maxCoeff(), 1e-12);
  }
}

}  // namespace
}  // namespace kt
