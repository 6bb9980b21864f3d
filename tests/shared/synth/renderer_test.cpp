// Views against closed forms and against the exhaustive ray caster; the same bits for any number of threads.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/synth/renderer.h"

#include <cstring>
#include <gtest/gtest.h>

#include "shared/synth/mission.h"

namespace kt {
namespace {

using Eigen::Vector3d;

const Camera kSmall{80, 60, 65.625, 65.625, 39.5, 29.5, {}};

Vector3d ray(const Camera& camera, int u, int v) {
  return {(u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, 1};
}

TEST(Renderer, DepthOfAPlaneASphereAndABoxIsTheClosedForm) {
  // Camera at the origin looking along +z, world axes as the camera's.
  const auto z_of = [](const Shape& shape, const Pose& T) {
    Scene scene;
    scene.add(shape, T, {});
    return Renderer(scene, kSmall).render(Pose::Identity()).z_m;
  };
  Pose tilted = Pose::Identity();
  tilted.linear() = exp_so3({0, 0.4, 0});
  tilted.translation() = Vector3d(0, 0, 2);
  const Image<double> plane = z_of({ShapeKind::kQuad, {50, 50, 0}}, tilted);
  const Image<double> sphere = z_of({ShapeKind::kSphere, {0.5, 0, 0}}, tilted);
  Pose straight = Pose::Identity();
  straight.translation() = Vector3d(0, 0, 2);
  const Image<double> box = z_of({ShapeKind::kBox, {0.4, 0.3, 0.25}}, straight);
  const Vector3d n = tilted.linear().col(2);
  int on_sphere = 0, on_box = 0;
  for (int v = 0; v < kSmall.height; ++v) {
    for (int u = 0; u < kSmall.width; ++u) {
      const Vector3d d = ray(kSmall, u, v);
      EXPECT_NEAR(plane(u, v), 2 * n.z() / n.dot(d), 1e-9);
      // |z d - c|^2 = r^2 with c = (0, 0, 2).
      const double a = d.squaredNorm(), discriminant = 4 - a * (4 - 0.25);
      if (discriminant >= 0) {
        EXPECT_NEAR(sphere(u, v), (2 - std::sqrt(discriminant)) / a, 1e-9);
      } else {
        EXPECT_EQ(sphere(u, v), std::numeric_limits<double>::infinity());
      }
      on_sphere += discriminant >= 0;
      // The front face at z = 1.75 covers |x| <= 0.4, |y| <= 0.3; nothing else of the box is in view.
      const bool front = std::abs(1.75 * d.x()) <= 0.4 && std::abs(1.75 * d.y()) <= 0.3;
      EXPECT_EQ(box(u, v), front ? 1.75 : std::numeric_limits<double>::infinity());
      on_box += front;
    }
  }
  EXPECT_GT(on_sphere, 500);
  EXPECT_GT(on_box, 500);
}

TEST(Renderer, CullingNeverChangesWhatARayMeets) {
  for (const char* name : {"room", "apartment", "ring"}) {
    const SyntheticMission mission(name, {.downscale = 8, .threads = 1});
    const Scene& scene = mission.scene();
    const Renderer renderer(scene, kSmall);
    for (int64_t i = 3; i < mission.frame_count(); i += mission.frame_count() / 4) {
      const Pose& T = mission.groundtruth()[static_cast<size_t>(i)].T_odom_camera;
      const View view = renderer.render(T);
      for (int v = 0; v < kSmall.height; v += 3) {
        for (int u = 0; u < kSmall.width; u += 3) {
          const auto hit = scene.cast(T.translation(), T.linear() * ray(kSmall, u, v));
          ASSERT_EQ(hit.has_value(), view.face(u, v) >= 0);
          if (!hit) continue;
          ASSERT_NEAR(view.z_m(u, v), hit->distance, 1e-9)
              << name << " frame " << i << " pixel " << u << " " << v;
          const double cosine = -hit->n_world.dot((T.linear() * ray(kSmall, u, v)).normalized());
          if (view.face(u, v) / View::kMaxFaces == hit->primitive &&
              view.face(u, v) % View::kMaxFaces == hit->at.face) {
            EXPECT_NEAR(view.cos_incidence(u, v), cosine, 1e-6);
          }
        }
      }
    }
  }
}

TEST(Renderer, ThreadsDoNotChangeABit) {
  const SyntheticMission mission("room", {.downscale = 4, .threads = 1});
  const Camera& camera = mission.calibration().depth;
  const Pose& T = mission.groundtruth()[100].T_odom_camera;
  const View one = Renderer(mission.scene(), camera, 1).render(T),
             three = Renderer(mission.scene(), camera, 3).render(T);
  EXPECT_EQ(one.z_m, three.z_m);
  EXPECT_EQ(one.face, three.face);
  EXPECT_EQ(0, std::memcmp(one.radiance.data(), three.radiance.data(), one.radiance.pixels().size_bytes()));
}

TEST(Renderer, SmoothEdgesBlendTheTwoFacesOfABorder) {
  // A white half plane before a black one: its edge falls at u = 40.1, so samples at 40 - 0.25 see white, 40
  // + 0.25 black.
  Scene scene;
  const auto wall = [&](double x, double z, float light) {
    Pose T = Pose::Identity();
    T.translation() = Vector3d(x, 0, z);
    scene.add({ShapeKind::kQuad, {10, 10, 0}}, T, {Pattern::kPlain, {light, light, light}, {}, 1, 0});
  };
  wall((40.1 - kSmall.cx) / kSmall.fx * 2 - 10, 2, 1);
  wall(0, 3, 0);
  const View sharp = Renderer(scene, kSmall).render(Pose::Identity(), false);
  const View smooth = Renderer(scene, kSmall).render(Pose::Identity(), true);
  EXPECT_GT(sharp.radiance(40, 30).x, 0.2f);
  EXPECT_EQ(sharp.radiance(41, 30).x, 0);
  EXPECT_NEAR(smooth.radiance(40, 30).x, sharp.radiance(40, 30).x / 2, 1e-3);
  EXPECT_EQ(smooth.radiance(41, 30).x, 0);
  EXPECT_EQ(smooth.radiance(20, 30).x, sharp.radiance(20, 30).x);
}

}  // namespace
}  // namespace kt
