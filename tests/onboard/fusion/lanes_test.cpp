// Kernels in lanes give the same bits however many lanes there are: a GPU runs them with one.
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cstring>
#include <gtest/gtest.h>
#include <vector>

#include "onboard/fusion/brick_distances.h"
#include "onboard/fusion/integrate_kernel.h"
#include "onboard/fusion/raycast_kernel.h"
#include "shared/core/rng.h"
#include "tests/onboard/fusion/made_volumes.h"

namespace kt::test {
namespace {

template <typename T>
bool same_bits(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0;
}

// A volume of 8 x 8 x 8 bricks of voxels of 2 cm, wrapped in its ring, in memory of its own, with random
// content.
struct RandomVolume {
  static constexpr int kBricks = 8, kCount = kBricks * kBricks * kBricks;
  std::vector<Voxel> voxels = std::vector<Voxel>(kCount * kBrickVoxels);
  std::vector<ColourVoxel> colours = std::vector<ColourVoxel>(kCount * kBrickVoxels);
  std::vector<uint8_t> masks = std::vector<uint8_t>(kCount * kBrickColumns);
  std::vector<uint8_t> states = std::vector<uint8_t>(kCount, kBrickSurface);
  std::vector<uint32_t> last_seen = std::vector<uint32_t>(kCount);

  RandomVolume() {
    for (size_t i = 0; i < voxels.size(); ++i) {
      const auto random = [&](uint64_t stream) { return random_uniform(3, stream, i); };
      voxels[i] = Voxel::of(static_cast<int32_t>(60'000 * random(0)) - 30'000,
                            random(1) < 0.1 ? 0 : static_cast<int32_t>(1 + 500 * random(2)));
      if (random(3) < 0.1) voxels[i].word |= Voxel::kFrozen;
      colours[i] = ColourVoxel::of(static_cast<int32_t>(65'000 * random(4)), 7, 300,
                                   static_cast<int32_t>(200 * random(5)));
    }
  }
  VolumeView view() {
    return {voxels.data(), colours.data(), masks.data(), states.data(), last_seen.data(),
            kBricks,       {4, -4, 12},    {4, 4, 4},    0.02f,         0.1f};
  }
};

TEST(Lanes, OfFuseColumnsGiveTheSameBits) {
  const PinholeParams camera = small_calibration().depth.pinhole();
  std::vector<FusionPixel> pixels;
  std::vector<uint32_t> rgba;
  for (int64_t i = 0; i < camera.pixel_count(); ++i) {
    const auto random = [&](uint64_t stream) {
      return static_cast<float>(random_uniform(4, stream, static_cast<uint64_t>(i)));
    };
    pixels.push_back({0.9f + 0.4f * random(0), FusionPixel::packed(0.5f + random(1), random(2))});
    rgba.push_back(random(3) < 0.2f ? 0 : 0xff123456u + static_cast<uint32_t>(i % 100));
  }
  std::vector<int32_t> slots;
  for (int32_t slot = 0; slot < RandomVolume::kCount; ++slot) slots.push_back(slot);
  RandomVolume one, eight;
  const std::vector<Voxel> before = one.voxels;
  std::vector<uint8_t> fused_by_one(slots.size() * kBrickColumns), fused_by_eight = fused_by_one;
  const Rigid3f T_camera_volume = to_rigid3f(pose_of({3, 5, 2}, {-0.3, -0.3, 0.7}));
  const auto functor = [&](RandomVolume& volume, std::vector<uint8_t>& fused) {
    return FuseColumns{volume.view(), camera,      T_camera_volume, slots.data(),
                       pixels.data(), rgba.data(), 700.0f,          fused.data()};
  };
  const auto columns = static_cast<int64_t>(fused_by_one.size());
  for (int64_t i = 0; i < columns; ++i) functor(one, fused_by_one).run<1>(i);
  for (int64_t i = 0; i < columns; i += 8) functor(eight, fused_by_eight).run<8>(i);
  EXPECT_FALSE(same_bits(one.voxels, before)) << "nothing was fused";
  EXPECT_TRUE(same_bits(one.voxels, eight.voxels));
  EXPECT_TRUE(same_bits(one.colours, eight.colours));
  EXPECT_EQ(one.masks, eight.masks);
  EXPECT_EQ(fused_by_one, fused_by_eight);
}

TEST(Lanes, OfRaycastGiveTheSameBits) {
  VolumeConfig config;
  config.resolution = 128;
  config.voxel_size_m = 0.03;
  Recorder recorder{.scene = furnished_room(), .config = config};
  recorder.volume.follow(Pose::Identity());
  for (int i = 0; i < 3; ++i) recorder.fuse(pose_of({0, 2.0 * i, 0}, {0.02 * i, 0, 0}));
  PinholeParams camera = small_calibration().depth.pinhole().half();
  camera.width -= 3;  // tiles at the right reach beyond the image
  const VolumeView volume = recorder.volume.view();
  const auto tiles = static_cast<size_t>(RaycastPixel::element_count(camera) / kTilePixels);
  BrickDistances brick_distances(exec::Device::cpu(1), volume.bricks);
  brick_distances.measure(volume.brick_states);
  const std::vector<uint8_t> distances = brick_distances.by_slot().downloaded();
  EXPECT_GT(std::count(distances.begin(), distances.end(), kFarthestBrick), 0) << "rays leap nowhere";
  EXPECT_GT(std::count(distances.begin(), distances.end(), 1), 0);
  const std::vector<RayStretch> stretches(tiles, RayStretch{0.0f, 100.0f});
  const auto pixels = static_cast<size_t>(camera.pixel_count());
  const Pose T_volume_camera =
      Eigen::Translation3d(
          -Eigen::Vector3d(volume.origin_voxel().x, volume.origin_voxel().y, volume.origin_voxel().z) *
          config.voxel_size_m) *
      pose_of({1, 3, 2}, {0.01, 0.02, 0});
  std::vector<Vec4f> points[2], normals[2];
  for (int k = 0; k < 2; ++k) points[k].resize(pixels), normals[k].resize(pixels);
  const auto functor = [&](int k) {
    return RaycastPixel{
        {volume},         distances.data(), camera,           to_rigid3f(T_volume_camera), 0.1f, 100.0f,
        stretches.data(), points[k].data(), normals[k].data()};
  };
  for (int64_t i = 0; i < RaycastPixel::element_count(camera); ++i) functor(0).run<1>(i);
  for (int64_t i = 0; i < RaycastPixel::element_count(camera); i += 32) functor(1).run<32>(i);
  size_t hits = 0;
  for (const Vec4f& p : points[0]) hits += p.w > 0;
  EXPECT_GT(hits, pixels / 2);
  EXPECT_TRUE(same_bits(points[0], points[1]));
  EXPECT_TRUE(same_bits(normals[0], normals[1]));
}

}  // namespace
}  // namespace kt::test
