// Overlaps of views of a wall and of a box against closed forms.
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/eval/view_overlap.h"

#include <gtest/gtest.h>

#include "shared/core/check.h"
#include "shared/types/keyframe.h"
#include "tests/tools/eval/wall_views.h"

namespace kt {
namespace {

const PinholeParams kCamera = keyframe_camera(wall_calibration());

TEST(ViewOverlap, KeyframesHaveAQuarterOfTheDepthCamera) {
  EXPECT_EQ(kCamera.width, 160);
  EXPECT_EQ(kCamera.height, 120);
  EXPECT_FLOAT_EQ(kCamera.fx, 125);
  EXPECT_FLOAT_EQ(kCamera.cx, 79.5f);  // the middle of the image stays there
}

TEST(ViewOverlap, SideStepsAlongAWallLoseTheirWidth) {
  for (const double x : {0.0, 0.32, 0.64, -1.28, 2.4, 3.0}) {
    const double share = std::max(0.0, 1 - std::abs(x) / 2.56);
    EXPECT_NEAR(shared_view(kCamera, wall_depth(), wall_depth(), facing_wall(x)), share, 1.0 / 160) << x;
  }
}

TEST(ViewOverlap, TheCloserViewIsSharedWhollyButSharesAQuarter) {
  // From 1 m away the camera sees half the width and half the height.
  const Image<uint16_t> far = wall_depth(), near = wall_depth(1);
  EXPECT_EQ(shared_view(kCamera, near, far, facing_wall(0, 1)), 1);
  EXPECT_NEAR(shared_view(kCamera, far, near, facing_wall(0, -1)), 0.25, 0.01);
  EXPECT_TRUE(overlaps(kCamera, far, near, facing_wall(0, 1), 0.24));
  EXPECT_FALSE(overlaps(kCamera, far, near, facing_wall(0, 1), 0.26)) << "the smaller share counts";
  EXPECT_FALSE(overlaps(kCamera, near, far, facing_wall(0, -1), 0.26));
}

TEST(ViewOverlap, ATurnOnTheSpotLosesItsAngle) {
  // Inside a sphere around the camera: depth along z of pixel (u, v) is r / |ray|.
  Image<uint16_t> sphere(160, 120);
  for (int v = 0; v < 120; ++v) {
    for (int u = 0; u < 160; ++u) {
      const Vec3f ray = kCamera.unproject(static_cast<float>(u), static_cast<float>(v), 1);
      sphere(u, v) = static_cast<uint16_t>(3000 / norm(ray) + 0.5f);
    }
  }
  // The columns seen after a turn by a are those whose bearing lies a or more inside the edge; rows at the
  // edge come and go a little.
  const double half_angle = std::atan(80.0 / 125);
  for (const double angle : {0.1, 0.3, 0.6}) {
    Pose turn = Pose::Identity();
    turn.linear() = exp_so3({0, angle, 0});
    const double share = (80 + 125 * std::tan(half_angle - angle)) / 160;
    EXPECT_NEAR(shared_view(kCamera, sphere, sphere, turn), share, 0.06) << angle;
  }
  Pose back = Pose::Identity();
  back.linear() = exp_so3({0, 3, 0});
  EXPECT_EQ(shared_view(kCamera, sphere, sphere, back), 0) << "behind the camera";
}

TEST(ViewOverlap, WhatIsHiddenOrNotMeasuredThereIsNotShared) {
  Image<uint16_t> box_in_front = wall_depth(), holes = wall_depth();
  for (int v = 0; v < 120; ++v) {
    for (int u = 0; u < 40; ++u) box_in_front(u, v) = 1500, holes(u, v) = 0;
  }
  const Pose here = Pose::Identity();
  EXPECT_DOUBLE_EQ(shared_view(kCamera, wall_depth(), box_in_front, here), 0.75);
  EXPECT_DOUBLE_EQ(shared_view(kCamera, box_in_front, wall_depth(), here), 0.75) << "it has gone";
  EXPECT_DOUBLE_EQ(shared_view(kCamera, wall_depth(), holes, here), 0.75);
  EXPECT_DOUBLE_EQ(shared_view(kCamera, holes, wall_depth(), here), 1) << "of what has depth";
  EXPECT_EQ(shared_view(kCamera, Image<uint16_t>(160, 120), wall_depth(), here), 0);
}

TEST(ViewOverlap, DepthMayDifferByFiveCentimetresAndTheNoise) {
  // 3 sigma at 2 m are 18 mm.
  EXPECT_EQ(shared_view(kCamera, wall_depth(), Image<uint16_t>(160, 120, 2067), Pose::Identity()), 1);
  EXPECT_EQ(shared_view(kCamera, wall_depth(), Image<uint16_t>(160, 120, 2069), Pose::Identity()), 0);
}

TEST(ViewOverlap, ImagesOfAnotherCameraAreABug) {
  EXPECT_THROW(shared_view(kCamera, wall_depth(), Image<uint16_t>(80, 60), Pose::Identity()), LogicError);
}

}  // namespace
}  // namespace kt
