// Tests of the plain vectors of kernels.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/core/vec.h"

#include <limits>

#include "gtest/gtest.h"

namespace kt {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

TEST(Vec, LayoutIsThatOfTheGpu) {
  EXPECT_EQ(sizeof(Vec3f), 12u);
  EXPECT_EQ(sizeof(Vec4f), 16u);
  EXPECT_EQ(alignof(Vec4f), 16u);
  EXPECT_EQ(sizeof(Rigid3f), 48u);
}

TEST(Vec, CrossIsPerpendicularAndRightHanded) {
  const Vec3f a{1, 2, 3}, b{-2, 0.5f, 4};
  const Vec3f c = cross(a, b);
  EXPECT_FLOAT_EQ(dot(a, c), 0);
  EXPECT_FLOAT_EQ(dot(b, c), 0);
  const Vec3f z = cross({1, 0, 0}, {0, 1, 0});
  EXPECT_EQ(z.z, 1);
}

TEST(Vec, RigidTransformRotatesThenTranslates) {
  const Rigid3f T{Mat3f{{0, -1, 0, 1, 0, 0, 0, 0, 1}}, {10, 20, 30}};  // 90 degrees about z
  const Vec3f p = T * Vec3f{1, 2, 3};
  EXPECT_EQ(p.x, 8);
  EXPECT_EQ(p.y, 21);
  EXPECT_EQ(p.z, 33);
}

TEST(Vec, MinAndMaxDropANaNOnTheLeft) {
  EXPECT_EQ(min_of(kNaN, 2.0f), 2.0f);
  EXPECT_EQ(max_of(kNaN, 2.0f), 2.0f);
  EXPECT_EQ(min_of(1.0f, 2.0f), 1.0f);
  EXPECT_EQ(max_of(1.0f, 2.0f), 2.0f);
}

}  // namespace
}  // namespace kt
