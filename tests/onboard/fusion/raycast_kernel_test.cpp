// Tests of the predicted surface against closed-form rays.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/fusion/raycast_kernel.h"

#include <cmath>
#include <numbers>

#include "gtest/gtest.h"

#include "shared/core/digest.h"
#include "tests/onboard/fusion/made_volumes.h"
#include "tests/support/devices.h"

namespace kt::test {
namespace {

struct RaycastErrors {
  double mean_m = 0, worst_m = 0, mean_normal_deg = 0;
  int hits = 0, pixels = 0;
};

// Errors of the predicted points along their rays, where the surface is seen at less than 60 degrees.
RaycastErrors raycast_errors(const ModelView& view, const AnalyticScene& scene) {
  RaycastErrors errors;
  const std::vector<Vec4f> points = view.points.downloaded(), normals = view.normals.downloaded();
  for (int v = 0; v < view.camera.height; ++v) {
    for (int u = 0; u < view.camera.width; ++u) {
      const Vec3f ray = view.camera.unproject(static_cast<float>(u), static_cast<float>(v), 1.0f);
      const auto hit = scene.trace(view.T_odom_camera.translation(),
                                   view.T_odom_camera.linear() * Eigen::Vector3d(ray.x, ray.y, ray.z));
      if (!hit) continue;
      const Eigen::Vector3d p_true = view.T_odom_camera.inverse() * hit->p_world,
                            n_true = view.T_odom_camera.linear().transpose() * hit->n_world;
      if (-n_true.dot(p_true.normalized()) < 0.5) continue;
      ++errors.pixels;
      const auto i = static_cast<size_t>(v * view.camera.width + u);
      if (points[i].w == 0) continue;
      ++errors.hits;
      const Eigen::Vector3d p(points[i].x, points[i].y, points[i].z),
          n(normals[i].x, normals[i].y, normals[i].z);
      EXPECT_LT(p.normalized().cross(p_true.normalized()).norm(), 1e-5)
          << "a point lies on the ray of its pixel";
      EXPECT_NEAR(n.norm(), 1, 1e-5);
      EXPECT_LT(n.dot(p), 0) << "normals face the camera";
      const double error = (p - p_true).norm();
      errors.mean_m += error;
      errors.worst_m = std::max(errors.worst_m, error);
      errors.mean_normal_deg += std::acos(std::clamp(n.dot(n_true), -1.0, 1.0)) * 180 / std::numbers::pi;
    }
  }
  errors.mean_m /= errors.hits;
  errors.mean_normal_deg /= errors.hits;
  return errors;
}

VolumeConfig volume_of(double voxel_size_m, int resolution) {
  VolumeConfig config;
  config.voxel_size_m = voxel_size_m;
  config.resolution = resolution;
  return config;
}

TEST(Raycast, OfAWallHitsItToAFractionOfAMillimetre) {
  Recorder recorder{.scene = AnalyticScene({Plane{{0, 0, -1}, -1.0}}), .config = volume_of(0.02, 128)};
  recorder.volume.follow(Pose::Identity());
  recorder.fuse(Pose::Identity());
  const RaycastErrors errors = raycast_errors(recorder.volume.raycast(Pose::Identity()), recorder.scene);
  EXPECT_GT(errors.hits, 0.93 * errors.pixels) << "all but the rim";
  EXPECT_LT(errors.mean_m, 1e-4);
  EXPECT_LT(errors.worst_m, 5e-4);
  EXPECT_LT(errors.mean_normal_deg, 0.1);
}

TEST(Raycast, FromElsewhereSeesTheSameWall) {
  Recorder recorder{.scene = AnalyticScene({Plane{Eigen::Vector3d(0.3, -0.2, -1).normalized(), -1.1}}),
                    .config = volume_of(0.02, 128)};
  recorder.volume.follow(Pose::Identity());
  for (int i = 0; i < 3; ++i) recorder.fuse(pose_of({0, 0, 0}, {0.02 * i, 0.01 * i, 0}));
  for (const Pose& T : {pose_of({0, 15, 0}, {-0.2, 0, 0.1}), pose_of({-10, 0, 30}, {0, 0.1, -0.1})}) {
    const RaycastErrors errors = raycast_errors(recorder.volume.raycast(T), recorder.scene);
    EXPECT_GT(errors.hits, errors.pixels / 2);
    EXPECT_LT(errors.mean_m, 0.001);
    EXPECT_LT(errors.worst_m, 0.01);
    EXPECT_LT(errors.mean_normal_deg, 2);
  }
}

TEST(Raycast, OfASphereIsRound) {
  const AnalyticScene scene({Sphere{{0.05, 0, 1.2}, 0.5}});
  Recorder recorder{.scene = scene, .config = volume_of(0.02, 128)};
  recorder.volume.follow(Pose::Identity());
  for (int i = 0; i < 5; ++i) recorder.fuse(pose_of({0, 0, 0}, {0.011 * i, 0.007 * i, 0}));
  const RaycastErrors errors = raycast_errors(recorder.volume.raycast(Pose::Identity()), scene);
  EXPECT_GT(errors.hits, 0.95 * errors.pixels);
  EXPECT_LT(errors.mean_m, 0.0015);
  EXPECT_LT(errors.mean_normal_deg, 2);
}

TEST(Raycast, OfARoomIsCompleteAndExact) {
  Recorder recorder{.scene = furnished_room(), .config = volume_of(0.03, 192)};
  recorder.volume.follow(Pose::Identity());
  for (int i = 0; i < 6; ++i) recorder.fuse(pose_of({0, 0, 0}, {0.013 * i, 0.017 * (i % 3), 0}));
  const RaycastErrors errors =
      raycast_errors(recorder.volume.raycast(pose_of({0, 0, 0}, {0.02, 0.02, 0})), recorder.scene);
  EXPECT_GT(errors.hits, 0.93 * errors.pixels) << "all but silhouettes";
  EXPECT_LT(errors.mean_m, 0.005);
  EXPECT_LT(errors.mean_normal_deg, 5);
}

// From close to a side face of the volume, along it: neighbouring rays leave the volume at very different
// depths.
TEST(Raycast, SeesAWallToTheVolumesEdge) {
  Recorder recorder{.scene = AnalyticScene({Plane{{0, 0, -1}, -2.0}}), .config = volume_of(0.02, 128)};
  recorder.volume.follow(Pose::Identity());
  for (const double turn : {-40.0, -20.0, 0.0, 20.0, 40.0}) recorder.fuse(pose_of({0, turn, 0}, {0, 0, 0}));
  const VolumeView volume = recorder.volume.view();
  const double edge_m = 0.02 * (volume.origin_voxel().x + volume.voxels_per_axis() - 3);
  int inside = 0, seen = 0;
  for (double x = 0.8; x < 1.15; x += 0.02) {
    const ModelView& view = recorder.volume.raycast(pose_of({0, 0, 0}, {x, 0, 0}));
    const std::vector<Vec4f> points = view.points.downloaded();
    for (int v = 0; v < view.camera.height; ++v) {
      for (int u = 0; u < view.camera.width; ++u) {
        const Vec3f p = view.camera.unproject(static_cast<float>(u), static_cast<float>(v), 2.0f);
        const double p_x = x + static_cast<double>(p.x);
        if (p_x < 0 || p_x > edge_m || std::abs(p.y) > 0.5f) continue;
        ++inside;
        seen += points[static_cast<size_t>(v * view.camera.width + u)].w > 0;
      }
    }
  }
  EXPECT_GT(inside, 5'000);
  EXPECT_EQ(seen, inside);
}

TEST(Raycast, SeesNothingInAnEmptyVolumeOrFromBehind) {
  Recorder recorder{.scene = AnalyticScene({Plane{{0, 0, -1}, -1.0}}), .config = volume_of(0.02, 128)};
  recorder.volume.follow(Pose::Identity());
  const auto hits = [&](const Pose& T) {
    int count = 0;
    for (const Vec4f& p : recorder.volume.raycast(T).points.downloaded()) count += p.w > 0;
    return count;
  };
  EXPECT_EQ(hits(Pose::Identity()), 0);
  recorder.fuse(Pose::Identity());
  EXPECT_GT(hits(Pose::Identity()), 4'000);
  EXPECT_EQ(hits(pose_of({0, 180, 0}, {0, 0, 0})), 0) << "turned away";
  EXPECT_EQ(hits(pose_of({0, 180, 0}, {0, 0, 2.0})), 0) << "the back of the wall";
  EXPECT_EQ(hits(pose_of({0, 0, 0}, {100, 0, 0})), 0) << "far outside";
}

TEST(Raycast, SurvivesRaysAlongTheGrid) {
  Recorder recorder{.scene = AnalyticScene({Plane{{0, 0, -1}, -1.0}}), .config = volume_of(0.02, 128)};
  recorder.volume.follow(Pose::Identity());
  recorder.fuse(Pose::Identity());
  for (const double turn : {0.0, 90.0, 180.0, 270.0}) {
    for (const Eigen::Vector3d& axis : {Eigen::Vector3d(0, 1, 0), Eigen::Vector3d(1, 0, 0)}) {
      // Starts on a corner of a voxel, brick and block, looking along an axis.
      for (const Vec4f& p :
           recorder.volume.raycast(pose_of(turn * axis, {0.64, 0.64, 0.64})).points.downloaded()) {
        ASSERT_TRUE(std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z));
      }
    }
  }
}

TEST(Raycast, GivesTheSameBitsOnEveryDevice) {
  uint64_t reference = 0;
  for (const exec::Device& device : parity_devices()) {
    Recorder recorder{.device = device,
                      .scene = furnished_room(),
                      .config = volume_of(0.04, 128),
                      .render_options = {.noise_sigmas = 1, .seed = 5}};
    recorder.volume.follow(Pose::Identity());
    for (int i = 0; i < 3; ++i) recorder.fuse(pose_of({0, 3.0 * i, 0}, {0.05 * i, 0, 0}));
    const ModelView& view = recorder.volume.raycast(pose_of({2, 4, 1}, {0.03, 0.01, 0.02}));
    Digest digest;
    digest.add(std::span<const Vec4f>(view.points.downloaded()));
    digest.add(std::span<const Vec4f>(view.normals.downloaded()));
    if (reference == 0) reference = digest.value();
    EXPECT_EQ(digest.value(), reference) << name_of(device);
  }
}

}  // namespace
}  // namespace kt::test
