// Tests of the search among all keyframes: a camera that turns twice in a room.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/loop_search/loop_search.h"

#include <set>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

#include "onboard/loops/keyframe_maker.h"
#include "tests/support/analytic_scene.h"
#include "tests/support/pose_matchers.h"
#include "tests/support/test_files.h"

namespace kt::test {
namespace {

constexpr int kTurn = 18, kKeyframes = 27;
const Calibration kCalibration = small_calibration(2);

Pose T_world_camera(int k) { return pose_of({0, 20.0 * k, 0}, {0.02 * k, -0.005 * k, 0.01 * k}); }

std::vector<Keyframe> keyframes() {
  Preprocessor preprocessor(exec::Device::cpu(1), kCalibration, {});
  KeyframeMaker maker(kCalibration, PlaceFeature::kSurf);
  std::vector<Keyframe> all;
  for (int k = 0; k < kKeyframes; ++k) {
    const RgbdFrame frame =
        render(furnished_room(), kCalibration, T_world_camera(k), {.sequence = 10 * k, .blotches_m = 0.12});
    StampedPose pose;
    pose.sequence = frame.sequence;
    pose.T_odom_camera = T_world_camera(k);
    all.push_back(maker.make(KeyframeMaker::images_of(preprocessor.process(frame), frame.colour, pose)));
  }
  return all;
}

const std::vector<Keyframe>& turning() {
  static const std::vector<Keyframe> made = keyframes();
  return made;
}

std::vector<Pose> poses() {
  std::vector<Pose> all;
  for (int k = 0; k < kKeyframes; ++k) all.push_back(T_world_camera(k));
  return all;
}

std::set<std::pair<int64_t, int64_t>> pairs_of(const std::vector<LoopClosure>& loops, bool accepted) {
  std::set<std::pair<int64_t, int64_t>> pairs;
  for (const LoopClosure& loop : loops) {
    if (!accepted || loop.accepted()) pairs.emplace(loop.from, loop.to);
  }
  return pairs;
}

TEST(LoopSearch, FindsTheSecondTurnAndGetsItRight) {
  LoopSearch search(kCalibration, turning(), {});
  const std::vector<int> one_group(kKeyframes, 0);
  double last = 0;
  const auto loops = search.search(poses(), one_group, [&](double share) { last = share; });
  EXPECT_GT(last, 0);
  std::set<int64_t> closed;
  for (const LoopClosure& loop : loops) {
    EXPECT_LT(loop.from, loop.to);
    if (!loop.accepted()) continue;
    if (loop.to - loop.from > 100) closed.insert(loop.to);
    const Pose truth = T_world_camera(static_cast<int>(loop.from / 10)).inverse() *
                       T_world_camera(static_cast<int>(loop.to / 10));
    EXPECT_POSE_NEAR(loop.T_from_to, truth, 1.0, 0.03);
  }
  EXPECT_GE(closed.size(), static_cast<size_t>(kKeyframes - kTurn - 1));
}

TEST(LoopSearch, ComparesNoPairTwiceAndGoesOnWithBetterPoses) {
  LoopSearch search(kCalibration, turning(), {.similar = 0, .near = 2, .verification = {}});
  const std::vector<int> apart = [] {
    std::vector<int> group;
    for (int k = 0; k < kKeyframes; ++k) group.push_back(k < kTurn ? 0 : 1);
    return group;
  }();
  const auto first = search.search(poses(), apart);
  for (const LoopClosure& loop : first)
    EXPECT_EQ(loop.from < 10 * kTurn, loop.to < 10 * kTurn) << "poses of different groups say nothing";
  const auto second = search.search(poses(), std::vector<int>(kKeyframes, 0));
  EXPECT_THAT(pairs_of(second, true), testing::Contains(testing::Pair(0, 10 * kTurn)));
  for (const auto& pair : pairs_of(second, false)) EXPECT_FALSE(pairs_of(first, false).contains(pair));
  if (!first.empty() && !second.empty()) {
    EXPECT_EQ(second.front().sequence, static_cast<int64_t>(first.size()));
  }
}

TEST(LoopSearch, TheNumberOfThreadsDoesNotMatter) {
  const auto run = [](int threads) {
    return LoopSearch(kCalibration, turning(), {}, threads).search(poses(), std::vector<int>(kKeyframes, 0));
  };
  const auto one = run(1), three = run(3);
  ASSERT_EQ(one.size(), three.size());
  for (size_t i = 0; i < one.size(); ++i) {
    EXPECT_EQ(one[i].from, three[i].from);
    EXPECT_EQ(one[i].to, three[i].to);
    EXPECT_EQ(one[i].sequence, three[i].sequence);
    EXPECT_EQ(one[i].verdict, three[i].verdict);
    EXPECT_EQ(one[i].T_from_to.matrix(), three[i].T_from_to.matrix());
    EXPECT_EQ(one[i].information, three[i].information);
  }
}

TEST(LoopSearch, ADepthImageOfAnotherSizeIsNone) {
  std::vector<Keyframe> keyframes = turning();
  Keyframe& other = keyframes[kTurn];  // where the first one was
  other.depth = Image<uint16_t>(3, 2, uint16_t{1000});
  const auto loops = LoopSearch(kCalibration, keyframes, {}).search(poses(), std::vector<int>(kKeyframes, 0));
  EXPECT_THAT(pairs_of(loops, false), testing::Contains(testing::Pair(0, other.sequence)));
  for (const auto& [from, to] : pairs_of(loops, true)) {
    EXPECT_NE(from, other.sequence);
    EXPECT_NE(to, other.sequence);
  }
  EXPECT_FALSE(pairs_of(loops, true).empty());
}

TEST(LoopSearch, RefusesMixedDescriptorsAndTakesNone) {
  std::vector<Keyframe> mixed = turning();
  mixed.back().descriptor_type = "orb256";
  EXPECT_THAT(error_of([&] { LoopSearch(kCalibration, mixed, {}); }), testing::HasSubstr("orb256"));
  std::vector<Keyframe> longer = turning();  // more descriptors than features
  longer.back().descriptors.resize(2 * longer.back().descriptors.size());
  longer.back().descriptor_size *= 2;
  EXPECT_THAT(error_of([&] { LoopSearch(kCalibration, longer, {}); }), testing::HasSubstr("128 bytes"));
  EXPECT_TRUE(LoopSearch(kCalibration, {}, {}).search({}, {}).empty());
}

}  // namespace
}  // namespace kt::test
