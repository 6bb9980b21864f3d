// The selection of bricks against fusing all of them: what a frame measures is never left out.
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <gtest/gtest.h>
#include <vector>

#include "onboard/fusion/integrate_kernel.h"
#include "onboard/fusion/select_bricks_kernel.h"
#include "shared/core/rng.h"
#include "tests/onboard/fusion/made_volumes.h"

namespace kt::test {
namespace {

// An empty volume of 8 x 8 x 8 bricks, wrapped in its ring.
struct EmptyVolume {
  static constexpr int kBricks = 8, kCount = kBricks * kBricks * kBricks;
  std::vector<Voxel> voxels = std::vector<Voxel>(kCount * kBrickVoxels);
  std::vector<ColourVoxel> colours = std::vector<ColourVoxel>(kCount * kBrickVoxels);
  std::vector<uint8_t> masks = std::vector<uint8_t>(kCount * kBrickColumns);
  std::vector<uint8_t> states;
  std::vector<uint32_t> last_seen = std::vector<uint32_t>(kCount);

  explicit EmptyVolume(BrickState state) : states(kCount, state) {}
  VolumeView view() {
    return {voxels.data(), colours.data(), masks.data(), states.data(), last_seen.data(),
            kBricks,       {4, -4, 12},    {4, 4, 4},    0.02f,         0.08f};
  }
};

// Tiles of different depths, some without any: a tile that is not looked at makes a difference.
std::vector<FusionPixel> random_image(const PinholeParams& camera, uint64_t seed) {
  std::vector<FusionPixel> pixels;
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      const auto tile = static_cast<uint64_t>((v / kTileSide) * 1000 + u / kTileSide);
      const bool is_empty = random_uniform(seed, 0, tile) < 0.6;
      const auto depth_m = static_cast<float>(0.5 + 1.5 * random_uniform(seed, 1, tile));
      pixels.push_back({depth_m, FusionPixel::packed(1.0f, is_empty ? 0.0f : 1.0f)});
    }
  }
  return pixels;
}

// Bricks that the frame changes, or brings near a surface, and that are not selected.
int count_left_out(const PinholeParams& camera, const RowMotion& shutter, BrickState state, uint64_t seed,
                   int* changed) {
  EmptyVolume volume(state);
  const auto random = [&](uint64_t i) { return 2 * random_uniform(seed, 2, i) - 1; };
  const Pose T_camera_volume =
      Eigen::Translation3d(0.6 * random(0), 0.6 * random(1), 1.0 + 0.4 * random(2)) *
      pose_of({180 * random(3), 180 * random(4), 180 * random(5)}, {0, 0, 0}) *
      Eigen::Translation3d(Eigen::Vector3d::Constant(-0.5 * EmptyVolume::kBricks * kBrickSide * 0.02));
  const Rigid3f T = to_rigid3f(T_camera_volume);
  const std::vector<FusionPixel> pixels = random_image(camera, seed);
  const int across = (camera.width + kTileSide - 1) / kTileSide,
            down = (camera.height + kTileSide - 1) / kTileSide;
  std::vector<DepthRange> tile_rows(static_cast<size_t>(across * camera.height)),
      tiles(static_cast<size_t>(across * down));
  const TileRowDepthRange row_ranges{pixels.data(), camera.width, tile_rows.data()};
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < across; ++u) row_ranges(u, v);
  }
  const TileDepthRange ranges{tile_rows.data(), across, camera.height, tiles.data()};
  for (int v = 0; v < down; ++v) {
    for (int u = 0; u < across; ++u) ranges(u, v);
  }
  const auto select = [&](const VolumeView& view) {
    std::vector<uint8_t> by_brick(EmptyVolume::kCount), by_block(EmptyVolume::kCount);
    const SelectBricks bricks{view, camera, T, tiles.data(), by_brick.data(), shutter},
        blocks{view, camera, T, tiles.data(), by_block.data(), shutter};
    for (int64_t i = 0; i < EmptyVolume::kCount; ++i) bricks.run<1>(i);
    for (int64_t i = 0; i < EmptyVolume::kCount; i += SelectBricks::kBlockBricks)
      blocks.run<SelectBricks::kBlockBricks>(i);
    EXPECT_EQ(by_block, by_brick);
    return by_brick;
  };
  const std::vector<uint8_t> selected = select(volume.view());
  // Other surfaces in its block make no difference to a brick.
  std::vector<uint8_t> mixed_states = volume.states;
  for (uint64_t k = 0; k < 20; ++k)
    mixed_states[random_bits(seed, 3, k) % mixed_states.size()] = kBrickSurface;
  VolumeView mixed = volume.view();
  mixed.brick_states = mixed_states.data();
  const std::vector<uint8_t> mixed_selected = select(mixed);
  for (size_t slot = 0; slot < selected.size(); ++slot)
    EXPECT_TRUE(mixed_selected[slot] == selected[slot] || mixed_states[slot] != volume.states[slot]) << slot;

  std::vector<int32_t> slots;
  for (int32_t slot = 0; slot < EmptyVolume::kCount; ++slot) slots.push_back(slot);
  std::vector<uint8_t> fused(EmptyVolume::kCount * kBrickColumns);
  const FuseColumns fuse{volume.view(), camera,       T,      slots.data(), pixels.data(), nullptr,
                         700.0f,        fused.data(), shutter};
  for (int64_t i = 0; i < static_cast<int64_t>(fused.size()); ++i) fuse.run<1>(i);

  int left_out = 0;
  for (int slot = 0; slot < EmptyVolume::kCount; ++slot) {
    const auto first = static_cast<std::ptrdiff_t>(slot) * kBrickColumns;
    const std::vector<uint8_t>& marks = state == kBrickSurface ? fused : volume.masks;
    const bool is_changed = std::any_of(marks.begin() + first, marks.begin() + first + kBrickColumns,
                                        [](uint8_t mark) { return mark != 0; });
    *changed += is_changed;
    left_out += is_changed && !selected[static_cast<size_t>(slot)];
  }
  return left_out;
}

TEST(SelectBricks, LeavesOutNothingThatTheFrameMeasures) {
  for (const float focal_per_width : {0.8f, 0.5f, 0.2f}) {
    // The last tiles are cut off at both edges.
    const PinholeParams camera{focal_per_width * 150, focal_per_width * 150, 74.5f, 59.5f, 150, 120};
    // A shutter of 30 ms at 1 m/s and 2 rad/s.
    for (const RowMotion& shutter :
         {RowMotion{}, RowMotion{{5e-4f, -5e-4f, 5e-4f}, {2e-4f, 2e-4f, -2e-4f}, 59.5f}}) {
      for (const BrickState state : {kBrickSurface, kBrickEmpty}) {
        int changed = 0, left_out = 0;
        for (uint64_t seed = 0; seed < 60; ++seed)
          left_out += count_left_out(camera, shutter, state, seed, &changed);
        EXPECT_GT(changed, 500);
        EXPECT_EQ(left_out, 0) << "of " << changed << ", focal length " << camera.fx << " px, state "
                               << int{state} << ", " << shutter.omega.x << " rad per row";
      }
    }
  }
}

}  // namespace
}  // namespace kt::test
