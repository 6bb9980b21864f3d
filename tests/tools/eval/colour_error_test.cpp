// Tests of the comparison of colours.
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/eval/colour_error.h"

#include <gtest/gtest.h>

#include "shared/core/check.h"

namespace kt {
namespace {

// 21 x 21 points 1 cm apart around the origin of the plane z = z_m, ever redder along x and greener along y.
Mesh sheet(float z_m) {
  Mesh sheet;
  for (int y = -10; y <= 10; ++y) {
    for (int x = -10; x <= 10; ++x) {
      sheet.vertices.push_back({0.01f * static_cast<float>(x), 0.01f * static_cast<float>(y), z_m});
      sheet.colours.push_back({static_cast<uint8_t>(100 + 4 * x), static_cast<uint8_t>(100 + 4 * y), 60});
    }
  }
  return sheet;
}

TEST(ColourError, IsZeroForTheTruthWhereverItLies) {
  Pose T = Pose::Identity();
  T.translation() = Eigen::Vector3d(3, -2, 1);
  Mesh moved = sheet(0.004f);
  for (Vec3f& p : moved.vertices) p = p + Vec3f{-3, 2, -1};
  const ColourError error = colour_error(moved, sheet(0), T);
  EXPECT_EQ(error.compared, 21 * 21);
  EXPECT_EQ(error.mean, 0);
  EXPECT_EQ(error.factor[0], 1);
}

TEST(ColourError, TheExposureOfTheWholeMapIsFree) {
  Mesh map = sheet(0);
  for (Rgb8& colour : map.colours) colour = {colour.r, static_cast<uint8_t>(colour.g / 2), 90};
  const ColourError error = colour_error(map, sheet(0), Pose::Identity());
  EXPECT_NEAR(error.factor[1], 2, 0.001);
  EXPECT_NEAR(error.factor[2], 60.0 / 90, 1e-9);
  EXPECT_NEAR(error.mean, 0, 0.3);
}

TEST(ColourError, AveragesWhatDiffers) {
  Mesh map = sheet(0);
  for (size_t i = 0; i < map.colours.size(); i += 3) map.colours[i].b = 80;
  const ColourError error = colour_error(map, sheet(0), Pose::Identity());
  EXPECT_EQ(error.factor[2], 1) << "a third of the vertices does not move the median";
  EXPECT_NEAR(error.levels[2].mean, 20.0 / 3, 1e-9);
  EXPECT_NEAR(error.mean, 20.0 / 9, 1e-9);
}

TEST(ColourError, OnlyWhatIsNearIsCompared) {
  EXPECT_EQ(colour_error(sheet(0.012f), sheet(0), Pose::Identity(), 0.015).compared, 21 * 21);
  Mesh half = sheet(0);
  for (size_t i = 0; i < half.vertices.size() / 2; ++i) half.vertices[i].z = 0.02f;
  EXPECT_EQ(colour_error(half, sheet(0), Pose::Identity(), 0.015).compared, 21 * 21 - 21 * 21 / 2);
}

TEST(ColourError, WhatCannotBeComparedIsAnError) {
  Mesh grey = sheet(0);
  grey.colours.clear();
  EXPECT_THROW(colour_error(grey, sheet(0), Pose::Identity()), Error);
  EXPECT_THROW(colour_error(sheet(0), grey, Pose::Identity()), Error);
  EXPECT_THROW(colour_error(sheet(1), sheet(0), Pose::Identity()), Error);
}

}  // namespace
}  // namespace kt
