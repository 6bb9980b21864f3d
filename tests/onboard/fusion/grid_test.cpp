// Tests of the ring addressing of the volume.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/fusion/grid.h"

#include <vector>

#include "gtest/gtest.h"

namespace kt {
namespace {

constexpr int kBricksPerSide = 8;

int modulo(int a, int n) { return (a % n + n) % n; }

VolumeView view_at(Vec3i origin_brick) {
  VolumeView view;
  view.bricks = kBricksPerSide;
  view.origin_brick = origin_brick;
  view.ring_origin = {modulo(origin_brick.x, kBricksPerSide), modulo(origin_brick.y, kBricksPerSide),
                      modulo(origin_brick.z, kBricksPerSide)};
  return view;
}

// Every origin that a ring of this size can have, some of them twice round.
std::vector<Vec3i> origins() {
  std::vector<Vec3i> all;
  for (int x = -12; x <= 8; x += kBlockSide) {
    for (int y = -4; y <= 4; y += kBlockSide) {
      for (int z = -8; z <= 4; z += kBlockSide) all.push_back({x, y, z});
    }
  }
  return all;
}

TEST(VolumeView, SlotAndBrickInvertEachOther) {
  for (const Vec3i origin : origins()) {
    const VolumeView view = view_at(origin);
    for (int64_t slot = 0; slot < kBricksPerSide * kBricksPerSide * kBricksPerSide; ++slot)
      ASSERT_EQ(view.slot(view.brick(slot)), slot);
    for (int z = 0; z < kBricksPerSide; ++z) {
      for (int y = 0; y < kBricksPerSide; ++y) {
        for (int x = 0; x < kBricksPerSide; ++x)
          ASSERT_EQ(view.brick(view.slot({x, y, z})), (Vec3i{x, y, z}));
      }
    }
  }
}

TEST(VolumeView, EveryVoxelHasAPlaceOfItsOwn) {
  const VolumeView view = view_at({-4, 4, 8});
  const int n = view.voxels_per_axis();
  std::vector<bool> taken(static_cast<size_t>(n) * n * n);
  for (int z = 0; z < n; ++z) {
    for (int y = 0; y < n; ++y) {
      for (int x = 0; x < n; ++x) {
        const auto index = static_cast<size_t>(view.index({x, y, z}));
        ASSERT_LT(index, taken.size());
        ASSERT_FALSE(taken[index]);
        taken[index] = true;
      }
    }
  }
}

TEST(VolumeView, RowsOfABrickAreContiguous) {
  const VolumeView view = view_at({4, 0, -4});
  for (int x = 1; x < kBrickSide; ++x) EXPECT_EQ(view.index({16 + x, 5, 11}), view.index({16, 5, 11}) + x);
}

// What makes a shift free: a voxel that stays keeps its place in memory.
TEST(VolumeView, ShiftMovesNoVoxel) {
  const Vec3i steps[] = {{4, 0, 0}, {0, -4, 0}, {0, 0, 4}, {-4, 4, 4}, {4, 4, -4}};
  for (const Vec3i origin : origins()) {
    for (const Vec3i step : steps) {
      const VolumeView before = view_at(origin), after = view_at(origin + step);
      const int n = before.voxels_per_axis();
      for (int z = 0; z < n; z += 5) {
        for (int y = 0; y < n; y += 3) {
          for (int x = 0; x < n; ++x) {
            const Vec3i moved =
                Vec3i{x, y, z} - Vec3i{step.x * kBrickSide, step.y * kBrickSide, step.z * kBrickSide};
            if (!after.contains(moved)) continue;
            ASSERT_EQ(before.index({x, y, z}), after.index(moved));
          }
        }
      }
    }
  }
}

TEST(VolumeView, ContainsItsCubeOnly) {
  const VolumeView view = view_at({0, 0, 0});
  const int n = view.voxels_per_axis();
  EXPECT_TRUE(view.contains({0, 0, 0}));
  EXPECT_TRUE(view.contains({n - 1, n - 1, n - 1}));
  for (int axis = 0; axis < 3; ++axis) {
    const Vec3i unit{axis == 0, axis == 1, axis == 2};
    EXPECT_FALSE(view.contains(Vec3i{} - unit));
    EXPECT_FALSE(view.contains({unit.x * n, unit.y * n, unit.z * n}));
  }
}

TEST(Voxel, KeepsWeightApartFromTheFrozenFlag) {
  Voxel voxel = Voxel::of(-16384, 300);
  voxel.word |= Voxel::kFrozen;
  EXPECT_TRUE(voxel.is_frozen());
  EXPECT_EQ(voxel.weight_units(), 300);
  EXPECT_FLOAT_EQ(voxel.weight(), 300 / 128.0f);
  EXPECT_NEAR(voxel.tsdf(), -0.5f, 1e-4f);
}

}  // namespace
}  // namespace kt
