// Cutting a slice: parts within the limit, each a slice of its own, nothing lost.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/types/cloud_slice.h"

#include <gtest/gtest.h>

namespace kt {
namespace {

CloudSlice strip(uint32_t triangles) {
  CloudSlice slice{3, 1, 5, Pose::Identity(), 0.01, true, {}, {}};
  for (uint32_t i = 0; i < triangles + 2; ++i) {
    slice.vertices.emplace_back().key = EdgeKey::of({0, 0, static_cast<int32_t>(i)}, 1);
    if (i >= 2) slice.triangles.push_back({i - 2, i, i - 1});
  }
  return slice;
}

TEST(SplitSlice, PartsKeepTheirTrianglesKeysAndOrder) {
  const CloudSlice whole = strip(10);
  const std::vector<CloudSlice> parts = split_slice(whole, 4);
  ASSERT_EQ(parts.size(), 3u);
  size_t next = 0;
  for (const CloudSlice& part : parts) {
    EXPECT_LE(part.triangles.size(), 4u);
    EXPECT_EQ(part.sequence, 3);
    EXPECT_EQ(part.segment, 1);
    EXPECT_EQ(part.timestamp_us, 5);
    EXPECT_EQ(part.voxel_size_m, 0.01);
    EXPECT_EQ(part.is_final, &part == &parts.back());
    for (size_t i = 1; i < part.vertices.size(); ++i)
      EXPECT_LT(part.vertices[i - 1].key, part.vertices[i].key);
    for (const auto& triangle : part.triangles) {
      for (size_t corner = 0; corner < 3; ++corner) {
        EXPECT_EQ(part.vertices[triangle[corner]].key, whole.vertices[whole.triangles[next][corner]].key);
      }
      ++next;
    }
  }
  EXPECT_EQ(next, whole.triangles.size());
}

TEST(SplitSlice, WhatFitsStaysWhole) {
  EXPECT_EQ(split_slice(strip(10), 10).size(), 1u);
  EXPECT_EQ(split_slice(strip(10), 10)[0].triangles, strip(10).triangles);
  EXPECT_TRUE(split_slice(strip(10), 10)[0].is_final);
  ASSERT_EQ(split_slice(CloudSlice{}, 10).size(), 1u);
}

}  // namespace
}  // namespace kt
