// Tests of where the volume stands, what it accepts, and its equal bits on every device.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/fusion/tsdf_volume.h"

#include "gmock/gmock.h"
#include "gtest/gtest.h"

#include "shared/core/digest.h"
#include "tests/onboard/fusion/made_volumes.h"
#include "tests/onboard/fusion/mesh.h"
#include "tests/support/devices.h"

namespace kt::test {
namespace {

const PinholeParams kCamera = small_calibration().depth.pinhole();

VolumeConfig moving_volume() {
  VolumeConfig config;
  config.resolution = 96;
  config.voxel_size_m = 0.03125;  // blocks of 1 m, a volume of 3 m
  config.shift_distance_m = 0.8;
  config.aim_distance_m = 1.0;
  config.min_slice_weight = 0.2;
  return config;
}

TEST(TsdfVolume, RefusesImpossibleResolutions) {
  for (const int resolution : {-32, 0, 16, 33, 500, 4096}) {
    VolumeConfig config;
    config.resolution = resolution;
    try {
      TsdfVolume(exec::Device::cpu(1), kCamera, config);
      FAIL() << resolution;
    } catch (const Error& error) {
      EXPECT_THAT(error.what(),
                  testing::HasSubstr("volume.resolution must be a multiple of 32 between 32 and 2048, got " +
                                     std::to_string(resolution)));
    }
  }
}

TEST(TsdfVolume, IsPlacedAroundThePointAheadOfTheFirstCamera) {
  TsdfVolume volume(exec::Device::cpu(1), kCamera, moving_volume());
  EXPECT_FALSE(
      volume.follow(pose_of({0, 90, 0}, {10, 0, 0})).has_value());  // looks along +x: aims at (11, 0, 0)
  const Vec3i origin = volume.origin_voxel();
  const Eigen::Vector3d centre = (Eigen::Vector3d(origin.x, origin.y, origin.z).array() + 48) * 0.03125;
  EXPECT_LE((centre - Eigen::Vector3d(11, 0, 0)).cwiseAbs().maxCoeff(), 0.5 + 1e-9) << "to half a block";
}

TEST(TsdfVolume, StandsOnWholeBlocks) {
  TsdfVolume volume(exec::Device::cpu(1), kCamera, moving_volume());
  for (int i = 0; i < 40; ++i) {
    volume.follow(pose_of({0, 7.0 * i, 0}, {0.3 * i, -0.2 * i, -0.25 * i}));
    const Vec3i origin = volume.origin_voxel();
    EXPECT_EQ(origin.x % kBlockVoxels, 0);
    EXPECT_EQ(origin.y % kBlockVoxels, 0);
    EXPECT_EQ(origin.z % kBlockVoxels, 0);
  }
}

TEST(TsdfVolume, ShiftsOnceTheAimIsFarEnoughFromTheCentre) {
  TsdfVolume volume(exec::Device::cpu(1), kCamera, moving_volume());
  // Aims at (0.5, 0.5, 0.5), the centre of a volume whose lowest corner stands on (-1, -1, -1).
  const auto camera_at = [](double x) { return pose_of({0, 0, 0}, {0.5 + x, 0.5, -0.5}); };
  volume.follow(camera_at(0));
  const Vec3i origin = volume.origin_voxel();
  EXPECT_EQ(origin, (Vec3i{-32, -32, -32}));
  EXPECT_FALSE(volume.follow(camera_at(0.79)).has_value());
  EXPECT_EQ(volume.origin_voxel(), origin);
  EXPECT_TRUE(volume.follow(camera_at(0.81)).has_value()) << "empty, but a shift";
  EXPECT_EQ(volume.origin_voxel(), (Vec3i{0, -32, -32}));
  EXPECT_FALSE(volume.follow(camera_at(0.81)).has_value()) << "there already";
  EXPECT_TRUE(volume.follow(camera_at(-3)).has_value());
  EXPECT_EQ(volume.origin_voxel(), (Vec3i{-128, -32, -32}));
}

TEST(TsdfVolume, NeverLetsTheAimLeaveIt) {
  TsdfVolume volume(exec::Device::cpu(1), kCamera, moving_volume());
  for (int i = 0; i < 200; ++i) {
    const Pose T = pose_of({3.0 * i, 5.0 * i, 0}, {0.05 * i, 0.03 * i, -0.04 * i});
    volume.follow(T);
    const Eigen::Vector3d aim = T * Eigen::Vector3d(0, 0, 1.0) / 0.03125;
    const Vec3i origin = volume.origin_voxel();
    const Eigen::Vector3d local = aim - Eigen::Vector3d(origin.x, origin.y, origin.z);
    EXPECT_GT(local.minCoeff(), 16);
    EXPECT_LT(local.maxCoeff(), 80);
  }
}

TEST(TsdfVolume, FollowsSoonerWhereItIsSmall) {
  for (const int resolution : {96, 128, 192, 256, 512}) {
    VolumeConfig config;  // 1 cm, 1.5 m
    config.resolution = resolution;
    config.aim_distance_m = 0.3;
    TsdfVolume volume(exec::Device::cpu(1), kCamera, config);
    for (int i = 0; i < 200; ++i) {
      const Pose T = pose_of({0, 5.0 * i, 0}, {0.03 * i, 0, -0.02 * i});
      volume.follow(T);
      const Vec3i origin = volume.origin_voxel();
      const Eigen::Vector3d local =
          T * Eigen::Vector3d(0, 0, 0.3) / 0.01 - Eigen::Vector3d(origin.x, origin.y, origin.z);
      ASSERT_GT(local.minCoeff(), 0) << resolution;
      ASSERT_LT(local.maxCoeff(), resolution) << resolution;
    }
  }
}

TEST(TsdfVolume, BricksThatLeftComeBackAsTheyWere) {
  Recorder recorder{.scene = AnalyticScene::room({-1.2, -1, -1}, {1.2, 1, 1.5}), .config = moving_volume()};
  TsdfVolume& volume = recorder.volume;
  std::vector<StoredBrick> left;
  const auto keep = [&left](auto bricks) { left.insert(left.end(), bricks.begin(), bricks.end()); };
  const auto place = volume.next_place(Pose::Identity());
  ASSERT_TRUE(place);
  volume.move_to(*place, keep);
  EXPECT_TRUE(left.empty());
  EXPECT_FALSE(volume.next_place(Pose::Identity())) << "it stands there";
  recorder.fuse(Pose::Identity());
  const CloudSlice before = [&] {
    volume.take_all(keep);
    volume.move_to(*place, keep);
    volume.put(left);
    return volume.flush();
  }();
  EXPECT_GT(before.triangles.size(), 1000u);

  // Half of it leaves, and comes back. A brick that lies elsewhere is let alone.
  volume.move_to(*place, keep);
  volume.put(left);
  std::vector<StoredBrick> half;
  volume.move_to(*place + Vec3i{2 * kBlockSide, 0, 0},
                 [&half](auto bricks) { half.insert(half.end(), bricks.begin(), bricks.end()); });
  EXPECT_GT(half.size(), 0u);
  EXPECT_LT(half.size(), left.size());
  volume.move_to(*place, keep);
  half.push_back(half.front());
  half.back().brick = *place + Vec3i{-1, 0, 0};
  volume.put(half);
  const CloudSlice after = volume.flush();
  EXPECT_EQ(after.triangles, before.triangles);
  ASSERT_EQ(after.vertices.size(), before.vertices.size());
  for (size_t i = 0; i < after.vertices.size(); ++i)
    ASSERT_EQ(content(after.vertices[i]), content(before.vertices[i]));
}

// A slanted drive with noise: everything that leaves the volume and all that stays in it.
uint64_t drive(const exec::Device& device) {
  Recorder recorder{
      .device = device,
      .scene = AnalyticScene::room({-1.2, -1, -3}, {2.0, 0.9, 4.5}).with(Sphere{{0.3, 0.4, 2.0}, 0.4}),
      .config = moving_volume(),
      .render_options = {.noise_sigmas = 1, .seed = 6}};
  Digest digest;
  const auto add = [&](const CloudSlice& slice) {
    for (const SliceVertex& v : slice.vertices) {
      digest.add(v.key.bits);
      for (const float x : {v.p_odom.x, v.p_odom.y, v.p_odom.z, v.n_odom.x, v.n_odom.y, v.n_odom.z, v.weight})
        digest.add(x);
      digest.add_bytes(&v.colour, sizeof(v.colour));
      digest.add(v.pose_sequence);
    }
    for (const auto& triangle : slice.triangles) digest.add_bytes(triangle.data(), sizeof(triangle));
  };
  int slices = 0;
  for (int i = 0; i < 18; ++i) {
    const Pose T = pose_of({0, 1.0 * i, 0}, {0.05 * i, 0, -2 + 0.25 * i});
    if (const auto slice = recorder.volume.follow(T)) {
      add(*slice);
      slices += !slice->triangles.empty();
    }
    recorder.fuse(T);
  }
  EXPECT_GE(slices, 1) << "the drive must shift";
  digest.add(recorder.volume.digest());
  add(recorder.volume.flush());
  digest.add(recorder.volume.digest());
  return digest.value();
}

TEST(TsdfVolume, GivesTheSameBitsOnEveryDevice) {
  const uint64_t reference = drive(exec::Device::cpu(1));
  for (const exec::Device& device : parity_devices()) EXPECT_EQ(drive(device), reference) << name_of(device);
}

}  // namespace
}  // namespace kt::test
