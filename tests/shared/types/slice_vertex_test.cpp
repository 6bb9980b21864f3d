// Tests of the keys that weld slices.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/types/slice_vertex.h"

#include <algorithm>
#include <tuple>
#include <vector>

#include "gtest/gtest.h"

#include "shared/core/rng.h"

namespace kt {
namespace {

constexpr int32_t kLimit = EdgeKey::kLimit;

Vec3i random_voxel(uint64_t i) {
  const auto coordinate = [i](uint64_t stream) {
    return static_cast<int32_t>(random_bits(5, stream, i) % (2 * uint64_t{kLimit})) - kLimit;
  };
  return {coordinate(0), coordinate(1), coordinate(2)};
}

bool reads_back(Vec3i voxel, int axis) {
  const EdgeKey key = EdgeKey::of(voxel, axis);
  return key.voxel() == voxel && key.axis() == axis;
}

TEST(EdgeKey, ReadsBackOverTheWholeRange) {
  const int32_t ends[] = {-kLimit, -kLimit + 1, -1, 0, 1, kLimit - 2, kLimit - 1};
  for (const int32_t x : ends) {
    for (const int32_t y : ends) {
      for (const int32_t z : ends) {
        for (int axis = 0; axis < 3; ++axis)
          ASSERT_TRUE(reads_back({x, y, z}, axis)) << x << ' ' << y << ' ' << z << ' ' << axis;
      }
    }
  }
  for (uint64_t i = 0; i < 10'000; ++i) ASSERT_TRUE(reads_back(random_voxel(i), static_cast<int>(i % 3)));
}

TEST(EdgeKey, OrdersByZThenYThenXThenAxis) {
  std::vector<std::tuple<int, int, int, int>> tuples;
  std::vector<EdgeKey> keys;
  for (uint64_t i = 0; i < 2'000; ++i) {
    Vec3i voxel = random_voxel(i);
    if (i % 2) voxel = {voxel.x % 3, voxel.y % 3, voxel.z % 3};  // ties in the first coordinates
    const int axis = static_cast<int>(i % 3);
    tuples.emplace_back(voxel.z, voxel.y, voxel.x, axis);
    keys.push_back(EdgeKey::of(voxel, axis));
  }
  std::sort(tuples.begin(), tuples.end());
  std::sort(keys.begin(), keys.end());
  for (size_t i = 0; i < keys.size(); ++i) {
    const Vec3i voxel = keys[i].voxel();
    ASSERT_EQ(tuples[i], std::make_tuple(voxel.z, voxel.y, voxel.x, keys[i].axis()));
  }
}

TEST(EdgeKey, IsPlainDataForKernels) {
  EXPECT_TRUE(std::is_trivially_copyable_v<SliceVertex>);
  EXPECT_EQ(sizeof(EdgeKey), 8u);
}

}  // namespace
}  // namespace kt
