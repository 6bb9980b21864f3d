// Tests of the fusion of frames against closed-form distances, weights and colours.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/fusion/integrate_kernel.h"

#include <cmath>

#include "gtest/gtest.h"

#include "tests/onboard/fusion/made_volumes.h"

namespace kt::test {
namespace {

VolumeConfig small_volume(double voxel_size_m = 0.02, int resolution = 128) {
  VolumeConfig config;
  config.resolution = resolution;
  config.voxel_size_m = voxel_size_m;
  return config;
}

struct DistanceErrors {
  double mean_m = 0, worst_m = 0;
  int64_t count = 0;
};

// Fused against true distance of the voxels within half the truncation distance of a surface.
DistanceErrors distance_errors(const TsdfVolume& volume, const AnalyticScene& scene) {
  const double truncation_m = static_cast<double>(volume.view().truncation_m);
  DistanceErrors errors;
  for_each_observed(volume, [&](const Eigen::Vector3d& p, const Voxel& voxel, const ColourVoxel&) {
    const double fused = static_cast<double>(voxel.tsdf()) * truncation_m;
    if (std::abs(fused) > 0.5 * truncation_m) return;
    const double error = std::abs(fused - scene.distance(p));
    errors.mean_m += error;
    errors.worst_m = std::max(errors.worst_m, error);
    ++errors.count;
  });
  errors.mean_m /= static_cast<double>(errors.count);
  return errors;
}

TEST(FuseColumns, WallGivesItsTruncatedDistance) {
  Recorder recorder{.scene = AnalyticScene({Plane{{0, 0, -1}, -1.0}}), .config = small_volume()};
  recorder.volume.follow(Pose::Identity());
  recorder.fuse(Pose::Identity());
  const double truncation_m = 0.08;
  int64_t near = 0;
  for_each_observed(recorder.volume, [&](const Eigen::Vector3d& p, const Voxel& voxel, const ColourVoxel&) {
    const double distance = 1.0 - p.z();
    ASSERT_GE(distance, -truncation_m - 1e-4) << "what lies behind the surface is unknown";
    ASSERT_NEAR(voxel.tsdf() * truncation_m, std::min(distance, truncation_m), 2e-4) << p.transpose();
    near += std::abs(distance) < truncation_m;
  });
  EXPECT_GT(near, 15'000);
}

TEST(FuseColumns, TiltedWallsGiveTheDistanceToTheirPlane) {
  for (const auto& [about_x, about_y] : {std::pair{30.0, 0.0}, {-20.0, 40.0}}) {
    const Eigen::Vector3d n = pose_of({about_x, about_y, 0}, {0, 0, 0}).linear() * Eigen::Vector3d(0, 0, -1);
    Recorder recorder{.scene = AnalyticScene({Plane{n, -1.0}}), .config = small_volume()};
    recorder.volume.follow(Pose::Identity());
    for (int i = 0; i < 4; ++i) recorder.fuse(pose_of({0, 0, 0}, {0.013 * i, 0.017 * i, 0}));
    const DistanceErrors errors = distance_errors(recorder.volume, recorder.scene);
    EXPECT_GT(errors.count, 5'000);
    // A voxel takes the nearest pixel: half a pixel beside it the wall is a little nearer or farther.
    EXPECT_LT(errors.mean_m, 0.0015);
    EXPECT_LT(errors.worst_m, 0.01);
  }
}

TEST(FuseColumns, RoomGivesTheDistanceToItsNearestSurface) {
  Recorder recorder{.scene = furnished_room(), .config = small_volume(0.03, 192)};
  recorder.volume.follow(Pose::Identity());
  for (int i = 0; i < 8; ++i)
    recorder.fuse(
        pose_of({0, 4.0 * (i % 4) - 6, 3.0 * (i % 3)}, {0.05 * (i % 3), 0.04 * (i % 2), 0.03 * (i % 4)}));
  const DistanceErrors errors = distance_errors(recorder.volume, recorder.scene);
  EXPECT_GT(errors.count, 20'000);
  EXPECT_LT(errors.mean_m, 0.006) << "creases and silhouettes of a coarse camera included";
}

TEST(FuseColumns, ARollingShutterBendsNothing) {
  Recorder rolling{.scene = furnished_room(), .calibration = small_calibration(2), .config = small_volume()};
  Calibration calibration = small_calibration(2);
  calibration.readout_s = 0.03;
  rolling.preprocessor = Preprocessor(rolling.device, calibration, {});
  rolling.calibration = calibration;
  rolling.render_options.velocity << 0.6, -0.4, 0.5, 0.5, -0.6, 0.7;  // rad/s, m/s
  Recorder still{.scene = furnished_room(), .calibration = small_calibration(2), .config = small_volume()};
  Recorder unaware{.scene = furnished_room(), .calibration = small_calibration(2), .config = small_volume()};
  for (Recorder* recorder : {&rolling, &still, &unaware}) recorder->volume.follow(Pose::Identity());
  rolling.fuse(Pose::Identity());
  still.fuse(Pose::Identity());
  const RgbdFrame frame = render(rolling.scene, calibration, Pose::Identity(), rolling.render_options);
  unaware.volume.integrate(unaware.preprocessor.process(frame), Pose::Identity(), 0);
  const double moving = distance_errors(rolling.volume, rolling.scene).mean_m,
               standing = distance_errors(still.volume, still.scene).mean_m,
               bent = distance_errors(unaware.volume, unaware.scene).mean_m;
  EXPECT_LT(moving, 1.2 * standing);
  EXPECT_GT(bent, 2 * standing);
}

TEST(FuseColumns, WeightsAddUpToTheirCap) {
  const PinholeParams camera = small_calibration().depth.pinhole();
  const exec::Device device = exec::Device::cpu(1);
  VolumeConfig config = small_volume();
  config.max_weight = 3;
  TsdfVolume volume(device, camera, config);
  volume.follow(Pose::Identity());
  const FrameMaps maps = uniform_maps(device, camera, wall_pixel(1.0f, 0.25f));
  for (int i = 1; i <= 16; ++i) {
    volume.integrate(maps, Pose::Identity(), i);
    EXPECT_EQ(voxel_at(volume, {0, 0, 1.0}).weight(), std::min(0.25f * static_cast<float>(i), 3.0f));
  }
}

TEST(FuseColumns, AveragesByWeight) {
  const PinholeParams camera = small_calibration().depth.pinhole();
  const exec::Device device = exec::Device::cpu(1);
  TsdfVolume volume(device, camera, small_volume());
  volume.follow(Pose::Identity());
  volume.integrate(uniform_maps(device, camera, wall_pixel(1.03f, 3), 0xff0000c8u), Pose::Identity(),
                   0);  // red 200
  volume.integrate(uniform_maps(device, camera, wall_pixel(0.99f, 1), 0xff006428u), Pose::Identity(),
                   1);  // red 40, green 100
  EXPECT_NEAR(voxel_at(volume, {0, 0, 1.0}).tsdf() * 0.08f, (3 * 0.03 + 1 * -0.01) / 4, 1e-5);
  const VolumeView view = volume.view();
  const ColourVoxel colour = view.colours[view.index(Vec3i{0, 0, 50} - view.origin_voxel())];
  EXPECT_NEAR(colour.r() / 256.0, (3 * 200 + 40) / 4.0, 0.05);
  EXPECT_NEAR(colour.g() / 256.0, 100 / 4.0, 0.05);
  EXPECT_EQ(colour.b(), 0);
  EXPECT_EQ(colour.weight_units(), 4 * 128);
}

TEST(FuseColumns, ColourIsAnAverageAtTheCapToo) {
  const PinholeParams camera = small_calibration().depth.pinhole();
  const exec::Device device = exec::Device::cpu(1);
  VolumeConfig config = small_volume();
  config.max_weight = 4;
  TsdfVolume volume(device, camera, config);
  volume.follow(Pose::Identity());
  for (int i = 0; i < 10; ++i)
    volume.integrate(uniform_maps(device, camera, wall_pixel(1.0f, 1), 0xff0000ffu), Pose::Identity(), i);
  for (int i = 0; i < 40; ++i)
    volume.integrate(uniform_maps(device, camera, wall_pixel(1.0f, 1), 0xffff0000u), Pose::Identity(), i);
  const VolumeView view = volume.view();
  const ColourVoxel colour = view.colours[view.index(Vec3i{0, 0, 50} - view.origin_voxel())];
  EXPECT_NEAR(colour.r() / 256.0, 255 * std::pow(0.8, 40), 1.0)
      << "the newest views win where the weight is capped";
  EXPECT_NEAR(colour.b() / 256.0, 255, 1.0);
}

TEST(FuseColumns, PixelsWithoutTrustOrColourChangeNothing) {
  const PinholeParams camera = small_calibration().depth.pinhole();
  const exec::Device device = exec::Device::cpu(1);
  TsdfVolume volume(device, camera, small_volume());
  volume.follow(Pose::Identity());
  volume.integrate(uniform_maps(device, camera, wall_pixel(1.0f, 1), 0xff0000ffu), Pose::Identity(), 0);
  const uint64_t before = volume.digest();
  volume.integrate(uniform_maps(device, camera, wall_pixel(1.0f, 0)), Pose::Identity(), 1);
  volume.integrate(uniform_maps(device, camera, FusionPixel{}), Pose::Identity(), 2);
  EXPECT_EQ(volume.digest(), before);
  volume.integrate(uniform_maps(device, camera, wall_pixel(1.0f, 1), 0), Pose::Identity(), 3);
  const VolumeView view = volume.view();
  EXPECT_EQ(view.colours[view.index(Vec3i{0, 0, 50} - view.origin_voxel())].weight_units(), 128)
      << "no colour, no colour weight";
}

TEST(FuseColumns, CarvesAnObjectThatWentAway) {
  const AnalyticScene empty({Plane{{0, 0, -1}, -1.6}});
  const Sphere ball{{0.1, 0.05, 1.1}, 0.2};
  VolumeConfig config = small_volume();
  config.max_weight = 10;
  Recorder recorder{.scene = empty.with(ball), .config = config};
  recorder.volume.follow(Pose::Identity());
  const auto ball_voxels = [&] {
    int64_t inside = 0;
    for_each_observed(recorder.volume, [&](const Eigen::Vector3d& p, const Voxel& voxel, const ColourVoxel&) {
      inside += (p - ball.centre).norm() < 0.3 && voxel.distance() < 0;
    });
    return inside;
  };
  for (int i = 0; i < 8; ++i) recorder.fuse(pose_of({0, 0, 0}, {0.01 * i, 0, 0}));
  EXPECT_GT(ball_voxels(), 500);
  recorder.scene = empty;
  for (int i = 0; i < 60; ++i) recorder.fuse(pose_of({0, 0, 0}, {0.01 * (i % 8), 0, 0}));
  EXPECT_EQ(ball_voxels(), 0);
  for (const SliceVertex& vertex : recorder.volume.flush().vertices)
    EXPECT_NEAR(vertex.p_odom.z, 1.6f, 0.03f) << "only the wall is left";
}

TEST(FuseColumns, SurvivesDepthFarFromTheVolume) {
  const PinholeParams camera = small_calibration().depth.pinhole();
  const exec::Device device = exec::Device::cpu(1);
  TsdfVolume volume(device, camera, small_volume());
  volume.follow(Pose::Identity());
  const uint64_t empty = volume.digest();
  volume.integrate(uniform_maps(device, camera, wall_pixel(60.0f, 1)), Pose::Identity(), 0);
  EXPECT_EQ(volume.digest(), empty) << "free space is stored only where surface was";
  volume.integrate(uniform_maps(device, camera, wall_pixel(1.0f, 1)), pose_of({0, 0, 0}, {500, 0, 0}), 1);
  EXPECT_EQ(volume.digest(), empty) << "a camera far outside";
}

}  // namespace
}  // namespace kt::test
