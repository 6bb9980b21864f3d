// Tests of the pinhole camera that kernels use.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/core/pinhole.h"

#include "gtest/gtest.h"

namespace kt {
namespace {

constexpr PinholeParams kCamera{525.0f, 520.0f, 319.5f, 239.5f, 640, 480};

TEST(PinholeParams, ProjectsWhatItUnprojects) {
  for (const float z : {0.3f, 1.0f, 5.5f}) {
    for (int v = 0; v < 480; v += 53) {
      for (int u = 0; u < 640; u += 71) {
        const Vec3f p = kCamera.unproject(static_cast<float>(u), static_cast<float>(v), z);
        EXPECT_FLOAT_EQ(p.z, z);
        EXPECT_NEAR(kCamera.project_u(p), u, 1e-4);
        EXPECT_NEAR(kCamera.project_v(p), v, 1e-4);
      }
    }
  }
}

TEST(PinholeParams, HalfSeesTheSameRays) {
  const PinholeParams half = kCamera.half();
  EXPECT_EQ(half.width, 320);
  EXPECT_EQ(half.height, 240);
  // The centre of a coarse pixel is the corner that its four fine pixels share.
  for (int v = 0; v < half.height; v += 37) {
    for (int u = 0; u < half.width; u += 41) {
      const Vec3f coarse = half.unproject(static_cast<float>(u), static_cast<float>(v), 1.0f);
      const Vec3f fine =
          kCamera.unproject(2.0f * static_cast<float>(u) + 0.5f, 2.0f * static_cast<float>(v) + 0.5f, 1.0f);
      EXPECT_NEAR(coarse.x, fine.x, 1e-6);
      EXPECT_NEAR(coarse.y, fine.y, 1e-6);
    }
  }
}

TEST(PinholeParams, HalfOfAnOddSizeDropsTheLastPixel) {
  const PinholeParams odd{100, 100, 50, 40, 101, 81};
  EXPECT_EQ(odd.half().width, 50);
  EXPECT_EQ(odd.half().height, 40);
}

TEST(PinholeParams, LevelsHalveOneAfterTheOther) {
  EXPECT_EQ(kCamera.at_level(0).width, kCamera.width);
  EXPECT_EQ(kCamera.at_level(2).width, kCamera.width / 4);
  EXPECT_EQ(kCamera.at_level(2).fx, kCamera.fx / 4);
  EXPECT_EQ(kCamera.at_level(2).cx, kCamera.half().half().cx);
}

TEST(DistortedPinholeParams, WithoutDistortionIsThePinhole) {
  const DistortedPinholeParams camera{kCamera};
  const Vec3f p{0.4f, -0.3f, 1.7f};
  float u = 0, v = 0;
  camera.project(p, &u, &v);
  EXPECT_NEAR(u, kCamera.project_u(p), 1e-4);
  EXPECT_NEAR(v, kCamera.project_v(p), 1e-4);
}

}  // namespace
}  // namespace kt
