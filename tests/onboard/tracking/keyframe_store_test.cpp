// Tests of the keyframes: what looks alike, what is near, and what goes when the store is full.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/tracking/keyframe_store.h"

#include <algorithm>
#include <numbers>
#include <set>

#include "gtest/gtest.h"

#include "tests/support/analytic_scene.h"
#include "tests/support/devices.h"

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

// Twenty views of a room, all around.
struct Views {
  static constexpr int kCount = 20;
  Calibration calibration = small_calibration();
  exec::Device device = exec::Device::cpu(1);
  Preprocessor preprocessor{device, calibration, {}};
  KeyframeStore store{device, 100};

  static Pose pose(int view) { return pose_of({0, 18.0 * view, 0}, {0.1, -0.1, 0.2}); }
  RgbdFrame frame(const Pose& T_world_camera) const {
    return render(furnished_room(), calibration, T_world_camera, {.noise_sigmas = 1, .blotches_m = 0.5});
  }
  PlaceCode code(const RgbdFrame& frame) { return store.code_of(preprocessor.process(frame)); }

  Views() {
    for (int view = 0; view < kCount; ++view) {
      StoredKeyframe added = keyframe(view, 0, pose(view));
      added.code = code(frame(pose(view)));
      store.add(std::move(added));
    }
  }
};

// Some look straight at a bare wall, where which of two points is farther is noise.
TEST(KeyframeStore, ThePlaceItselfComesFirst) {
  Views views;
  for (int view = 0; view < Views::kCount; ++view) {
    EXPECT_EQ(views.store.candidates(views.store.at(view).code, 1, 0), std::vector<int>{view});
    RgbdFrame moved = views.frame(Views::pose(view) * pose_of({1, -2, 1}, {0.03, 0.02, -0.04}));
    EXPECT_EQ(views.store.candidates(views.code(moved), 3, 0).front(), view) << "moved";
    for (Rgb8& c : moved.colour.pixels()) {
      const auto exposed = [](uint8_t level) { return static_cast<uint8_t>(0.6 * level + 10); };
      c = {exposed(c.r), exposed(c.g), exposed(c.b)};
    }
    EXPECT_EQ(views.store.candidates(views.code(moved), 3, 0).front(), view) << "moved and darker";
  }
}

TEST(KeyframeStore, CandidatesAreNoneTwiceAndCountAsAsked) {
  Views views;
  const std::vector<int> six = views.store.candidates(views.store.at(7).code, 4, 2);
  EXPECT_EQ(six.size(), 6u);
  EXPECT_EQ(std::set<int>(six.begin(), six.end()).size(), 6u);
  const std::vector<int> all = views.store.candidates(views.store.at(7).code, 100, 10);
  EXPECT_EQ(std::set<int>(all.begin(), all.end()).size(), size_t{Views::kCount});
  EXPECT_EQ(all.size(), size_t{Views::kCount});
  EXPECT_TRUE(KeyframeStore(views.device, 10).candidates({}, 3, 2).empty());
}

TEST(KeyframeStore, CandidatesInTurnReachEveryKeyframe) {
  Views views;
  std::set<int> reached;
  for (int call = 0; call < Views::kCount / 2; ++call) {
    const std::vector<int> some = views.store.candidates(views.store.at(3).code, 1, 2);
    EXPECT_EQ(some.front(), 3);
    EXPECT_LE(some.size(), 3u);
    reached.insert(some.begin(), some.end());
  }
  EXPECT_EQ(reached.size(), size_t{Views::kCount});
}

TEST(KeyframeStore, NeverHoldsMoreThanItsCapacityAndKeepsTheNewest) {
  for (int capacity = 1; capacity < 12; ++capacity) {
    KeyframeStore store(exec::Device::cpu(1), capacity);
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
  KeyframeStore store(exec::Device::cpu(1), 8);
  for (int64_t sequence = 0; sequence < 9; ++sequence) store.add(keyframe(sequence));
  EXPECT_EQ(sequences(store), (std::vector<int64_t>{0, 2, 4, 5, 6, 7, 8}));
}

// Distance in metres plus angle in radians.
TEST(KeyframeStore, NearestIsByThePapersMetricAndInItsSegment) {
  KeyframeStore store(exec::Device::cpu(1), 10);
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

TEST(KeyframeStore, CodesWithoutColourStillTellDepth) {
  Views views;
  RgbdFrame frame = views.frame(Views::pose(4)), other = views.frame(Views::pose(18));
  const PlaceCode coloured = views.code(frame);
  frame.colour = other.colour = {};
  const PlaceCode code = views.code(frame);
  for (size_t word = 0; word < 4; ++word) {
    EXPECT_EQ(code[word], 0u) << "of intensity";
    EXPECT_EQ(code[4 + word], coloured[4 + word]) << "of depth";
  }
  EXPECT_NE(views.code(other), code);
}

TEST(KeyframeStore, GivesTheSameCodesOnEveryDevice) {
  const Calibration calibration = small_calibration();
  const RgbdFrame frame = render(furnished_room(), calibration, Views::pose(2), {.blotches_m = 0.5});
  PlaceCode reference{};
  for (const exec::Device& device : parity_devices()) {
    Preprocessor preprocessor(device, calibration, {});
    const PlaceCode code = KeyframeStore(device, 10).code_of(preprocessor.process(frame));
    if (reference == PlaceCode{}) reference = code;
    EXPECT_EQ(code, reference) << name_of(device);
  }
  EXPECT_NE(reference, PlaceCode{});
}

}  // namespace
}  // namespace kt::test
