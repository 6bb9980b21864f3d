// Tests of the keyframes: what is near, and what goes when the store is full.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/tracking/keyframe_store.h"

#include <algorithm>
#include <numbers>

#include "gtest/gtest.h"

#include "tests/support/analytic_scene.h"

namespace kt::test {
namespace {

StoredKeyframe keyframe(int64_t sequence, int segment = 0, const Pose& T_odom_camera = Pose::Identity()) {
  StoredKeyframe result;
  result.sequence = sequence;
  result.segment = segment;
  result.T_odom_camera = T_odom_camera;
  return result;
}

std::vector<int64_t> sequences(const KeyframeStore& store) {
  std::vector<int64_t> all;
  for (int i = 0; i < store.size(); ++i) all.push_back(store.at(i).sequence);
  return all;
}

TEST(KeyframeStore, NeverHoldsMoreThanItsCapacityAndKeepsTheNewest) {
  for (int capacity = 1; capacity < 12; ++capacity) {
    KeyframeStore store(capacity);
    for (int64_t sequence = 0; sequence < 60; ++sequence) {
      store.add(keyframe(sequence));
      ASSERT_LE(store.size(), capacity);
      const std::vector<int64_t> kept = sequences(store);
      ASSERT_EQ(kept.back(), sequence);
      ASSERT_TRUE(std::is_sorted(kept.begin(), kept.end()));
      for (int64_t recent = 0; recent < std::min<int64_t>(sequence + 1, capacity / 2); ++recent)
        ASSERT_EQ(kept[kept.size() - 1 - static_cast<size_t>(recent)], sequence - recent) << capacity;
    }
    if (capacity >= 4) {
      EXPECT_EQ(sequences(store).front(), 0) << "where it began";
    }
  }
}

TEST(KeyframeStore, EverySecondOfTheOlderHalfGoes) {
  KeyframeStore store(8);
  for (int64_t sequence = 0; sequence < 9; ++sequence) store.add(keyframe(sequence));
  EXPECT_EQ(sequences(store), (std::vector<int64_t>{0, 2, 4, 5, 6, 7, 8}));
}

// Distance in metres plus angle in radians.
TEST(KeyframeStore, NearestIsByThePapersMetricAndInItsSegment) {
  KeyframeStore store(10);
  EXPECT_FALSE(store.nearest(0, Pose::Identity(), 0));
  store.add(keyframe(0, 0, pose_of({0, 0, 0}, {0, 0, 0.3})));
  store.add(keyframe(1, 0, pose_of({0, 10, 0}, {0.1, 0, 0})));
  store.add(keyframe(2, 1, pose_of({0, 0, 0}, {0, 0, 0.01})));
  const auto nearest = store.nearest(0, Pose::Identity(), 0);
  ASSERT_TRUE(nearest);
  EXPECT_EQ(nearest->index, 1);
  EXPECT_NEAR(nearest->distance, 0.1 + 10 * std::numbers::pi / 180, 1e-12);
  EXPECT_EQ(store.nearest(1, Pose::Identity(), 0)->index, 2);
  EXPECT_FALSE(store.nearest(2, Pose::Identity(), 0));
  const Pose elsewhere = pose_of({0, 5, 0}, {0, 0, 0.3});
  EXPECT_EQ(store.nearest(0, elsewhere, 0)->index, 0);
  EXPECT_NEAR(store.nearest(0, elsewhere, 0)->distance, 5 * std::numbers::pi / 180, 1e-12);
}

}  // namespace
}  // namespace kt::test
