// Tests of what the pipeline does where tracking is hard: gaps, blackouts, other places, bare walls.
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <vector>

#include "tests/onboard/app/recovery_scene.h"

namespace kt::test {
namespace {

const Place& elsewhere() {
  static const Place place{AnalyticScene::room({-1.2, -2, -3}, {2.5, 0.8, 1.8})
                               .with(Sphere{{-0.5, 0, 1.0}, 0.3})
                               .with(Box{{0.8, -0.2, 0.9}, {1.4, 0.8, 1.4}}),
                           2};
  return place;
}

// Slow enough for anything.
Pose stroll(double tick) {
  const double t = 0.15 * tick;
  return pose_of({3 * std::sin(t), 8 * std::sin(0.7 * t), 2 * std::sin(1.3 * t)},
                 {0.25 * std::sin(0.8 * t), 0.1 * std::sin(t), 0.3 * std::sin(0.5 * t)});
}

// Forward and to the right while turning left, until tick 7; then back, and the other way round.
Pose about_turn(int64_t tick) {
  const auto first = static_cast<double>(std::min<int64_t>(tick, 7)),
             then = static_cast<double>(std::max<int64_t>(tick - 7, 0));
  return pose_of({0, -0.5 * first + 1.5 * then, 0}, {0.012 * first - 0.014 * then, 0, 0.01 * first});
}

TEST(Recovery, FeaturesFindTheCameraAfterMissingFrames) {
  for (const int missing : {10, 20}) {
    Mission mission;
    for (int tick = 0; tick < 8; ++tick) mission.see(home(), about_turn(tick), tick);
    for (int tick = 8 + missing; tick < 12 + missing; ++tick) {
      const StampedPose& pose = mission.see(home(), about_turn(tick), tick);
      EXPECT_EQ(pose.status, TrackingStatus::kGood) << missing;
      EXPECT_EQ(pose.source, tick == 8 + missing ? PoseSource::kFeatures : PoseSource::kModel) << missing;
    }
  }
}

// More than a camera turns within 1/30 s, so not believed at once: then it may have.
TEST(Recovery, ASuddenTurnIsBelievedAtTheSecondFrame) {
  Mission mission;
  for (int tick = 0; tick < 5; ++tick) mission.see(home(), stroll(tick), tick);
  const Pose T_world_after = stroll(4) * turned(25);
  EXPECT_EQ(mission.see(home(), T_world_after, 5).status, TrackingStatus::kUncertain);
  EXPECT_EQ(mission.last().source, PoseSource::kFeatures);
  EXPECT_POSE_NEAR(mission.last().T_odom_camera, mission.truth(0, T_world_after), 1, 0.03);
  EXPECT_EQ(mission.last().cause, TrackingCause::kLargeStep);
  EXPECT_EQ(mission.see(home(), T_world_after, 6).status, TrackingStatus::kGood);
  EXPECT_EQ(mission.last().from_sequence, 4);
  EXPECT_EQ(mission.see(home(), T_world_after, 7).status, TrackingStatus::kGood);
}

TEST(Recovery, AFastTurnMayStopDead) {
  Mission mission;
  double yaw_deg = 0;
  int tick = 0;
  for (const double step_deg : {0, 4, 8, 12, 16, 18, 18, 0, 0, 0}) {
    yaw_deg += step_deg;
    EXPECT_EQ(mission.see(home(), turned(yaw_deg), tick).status, TrackingStatus::kGood) << tick;
    ++tick;
  }
}

TEST(Recovery, FindsTheCameraElsewhereAfterABlackout) {
  Mission mission;
  int tick = 0;
  const auto hurried = [](int k) { return pose_of({0, -2.0 * k, 0}, {0.015 * k, 0, 0}); };
  for (; tick < 8; ++tick) mission.see(home(), hurried(tick), tick);
  for (; tick < 38; ++tick) {
    EXPECT_EQ(mission.see_nothing(tick).status, TrackingStatus::kLost);
    EXPECT_EQ(mission.last().cause, TrackingCause::kNoDepth);
  }
  const Pose T_world_after = hurried(7) * pose_of({0, 10, 0}, {-0.15, 0, 0});
  for (; tick < 41 && mission.last().status != TrackingStatus::kGood; ++tick)
    mission.see(home(), T_world_after, tick);
  const StampedPose first = mission.last();
  ASSERT_EQ(first.status, TrackingStatus::kGood);
  EXPECT_LT(first.from_sequence, 8);
  for (const int end = tick + 3; tick < end; ++tick)
    EXPECT_EQ(mission.see(home(), T_world_after, tick).status, TrackingStatus::kGood);
}

// Noise before a hand, and the smooth hand.
TEST(Recovery, ACoveredLensIsNoPlace) {
  for (const bool is_smooth : {false, true}) {
    Mission mission;
    int tick = 0;
    for (; tick < 4; ++tick) mission.see(home(), stroll(tick), tick);
    for (int k = 0; k < 10; ++k, tick += 6) {
      RgbdFrame frame = black_frame(kFine, tick);
      for (int64_t i = 0; i < frame.depth.pixel_count(); ++i) {
        const auto normal = [i, tick](uint64_t seed) {
          return random_normal(seed, static_cast<uint64_t>(tick), static_cast<uint64_t>(i));
        };
        const double slope = static_cast<double>(i % frame.depth.width());
        frame.depth.data()[i] =
            static_cast<uint16_t>(is_smooth ? 4'000 + 3 * slope + 10 * normal(7) : 4'000 + 800 * normal(7));
        const auto level = static_cast<uint8_t>(std::clamp(10 + 4 * normal(8), 0.0, 255.0));
        frame.colour.data()[i] = {level, level, level};
      }
      EXPECT_NE(mission.take(frame).status, TrackingStatus::kGood);
      EXPECT_EQ(mission.last().segment, 0);
    }
    for (int k = 0; k < 3; ++k) mission.see(home(), stroll(4), tick++);
    EXPECT_EQ(mission.last().status, TrackingStatus::kGood) << "uncovered";
  }
}

TEST(Recovery, AKidnappedCameraIsFoundInAKnownPlace) {
  Mission mission;
  int tick = 0;
  for (; tick < 18; ++tick) mission.see(home(), turned(5.5 * tick), tick);
  const Pose T_world_after = pose_of({2, 3, 1}, {0.05, -0.03, 0.05});
  EXPECT_NE(mission.see(home(), T_world_after, tick++).status, TrackingStatus::kGood);
  EXPECT_EQ(mission.see(home(), T_world_after, tick++).status, TrackingStatus::kUncertain);
  EXPECT_EQ(mission.last().source, PoseSource::kRelocalised);
  EXPECT_EQ(mission.last().cause, TrackingCause::kUnconfirmed);
  EXPECT_EQ(mission.see(home(), T_world_after, tick++).status, TrackingStatus::kGood);
  EXPECT_EQ(mission.last().source, PoseSource::kRelocalised);
  EXPECT_LT(mission.last().from_sequence, 9) << "the edge starts at the keyframe: the jump is no motion";
  for (int k = 0; k < 3; ++k) {
    EXPECT_EQ(mission.see(home(), T_world_after, tick++).status, TrackingStatus::kGood);
    EXPECT_EQ(mission.last().source, PoseSource::kModel) << "no velocity";
    EXPECT_EQ(mission.last().from_sequence, tick - 2);
  }
}

// Largest distance of a slice's vertices from a place, seen from the camera where its segment began.
double largest_error_m(const CloudSlice& slice, const Place& place, const Pose& T_world_odom) {
  double largest = 0;
  for (const SliceVertex& vertex : slice.vertices) {
    const Eigen::Vector3d p_odom(vertex.p_odom.x, vertex.p_odom.y, vertex.p_odom.z);
    largest = std::max(largest, std::abs(place.scene.distance(T_world_odom * p_odom)));
  }
  return largest;
}

TEST(Recovery, AnUnknownPlaceIsAnotherSegment) {
  const CollectorConfig config = recovery_config();
  Mission mission(kFine, config);
  int tick = 0;
  for (; tick < 5; ++tick) mission.see(home(), stroll(tick), tick);
  const int carried_off = tick;
  for (; tick < 100 && mission.see(elsewhere(), stroll(tick), tick).status != TrackingStatus::kGood;
       tick += 3)
    EXPECT_EQ(mission.last().segment, 0);
  const StampedPose start = mission.last();
  const int begun = tick++;
  const double searched_s = static_cast<double>(stamp_us(begun) - stamp_us(carried_off - 1)) * 1e-6;
  EXPECT_GE(searched_s, config.tracking.new_segment_after_s);
  EXPECT_LT(searched_s, config.tracking.new_segment_after_s + 0.2);
  EXPECT_EQ(start.status, TrackingStatus::kGood);
  EXPECT_EQ(start.source, PoseSource::kStart);
  EXPECT_EQ(start.segment, 1);
  EXPECT_EQ(start.from_sequence, begun);
  EXPECT_EQ(start.T_odom_camera.matrix(), Eigen::Matrix4d::Identity());
  EXPECT_EQ(start.information, Matrix6d::Zero());
  ASSERT_FALSE(mission.sink.slices.empty());
  const size_t slices_before = mission.sink.slices.size();
  for (const CloudSlice& slice : mission.sink.slices) EXPECT_EQ(slice.segment, 0);

  for (int k = 0; k < 5; ++k, ++tick) {
    EXPECT_EQ(mission.see(elsewhere(), stroll(tick), tick).status, TrackingStatus::kGood);
    EXPECT_EQ(mission.last().segment, 1);
  }
  // Carried back.
  for (int k = 0; k < 3; ++k, ++tick) mission.see(home(), stroll(3 + 0.2 * k), tick);
  EXPECT_EQ(mission.last().status, TrackingStatus::kGood);
  EXPECT_EQ(mission.last().source, PoseSource::kRelocalised);
  EXPECT_EQ(mission.last().segment, 0);
  const size_t slices_elsewhere = mission.sink.slices.size();
  for (int k = 0; k < 3; ++k, ++tick) mission.see(home(), stroll(3.6 + 0.2 * k), tick);
  mission.collector.finish();

  const std::vector<CloudSlice>& slices = mission.sink.slices;
  ASSERT_GT(slices_elsewhere, slices_before);
  ASSERT_GT(slices.size(), slices_elsewhere);
  for (size_t i = 0; i < slices.size(); ++i) {
    const bool is_elsewhere = i >= slices_before && i < slices_elsewhere;
    EXPECT_EQ(slices[i].segment, is_elsewhere ? 1 : 0) << i;
    EXPECT_GT(slices[i].vertices.size(), 1'000u) << i;
    EXPECT_LT(is_elsewhere ? largest_error_m(slices[i], elsewhere(), stroll(begun))
                           : largest_error_m(slices[i], home(), stroll(0)),
              0.08)
        << i;
  }
  EXPECT_TRUE(slices.back().is_final);
  EXPECT_EQ(mission.collector.status().segments, 2);
}

TEST(Recovery, TheFinalSliceIsOfTheLastSegment) {
  CollectorConfig config = recovery_config();
  config.tracking.new_segment_after_s = 0.3;
  Mission mission(kCoarse, config);
  int tick = 0;
  for (; tick < 4; ++tick) mission.see(home(), stroll(tick), tick);
  for (; tick < 30; tick += 3) mission.see(elsewhere(), turned(0.1 * tick), tick);
  mission.collector.finish();
  ASSERT_EQ(mission.sink.slices.size(), 2u);
  EXPECT_EQ(mission.sink.slices[0].segment, 0);
  EXPECT_EQ(mission.sink.slices[1].segment, 1);
  EXPECT_TRUE(mission.sink.slices[1].is_final);
}

// Covered, carried, uncovered: much of what is seen fits, but not enough.
TEST(Recovery, ASimilarBareRoomIsNotTheKnownOne) {
  // One wall stands aslant; `side` 1: that to the right.
  const auto bare = [](double side) {
    return Place{
        AnalyticScene({Plane{{0, 0, -1}, -2.0}, Plane{{0, -1, 0}, -0.8}, Plane{{0, 1, 0}, -0.7},
                       Plane{{side, 0, 0}, -0.8}, Plane{Eigen::Vector3d(-side, 0, -0.9).normalized(), -1.3}}),
        0, 0};
  };
  const Place room = bare(1), mirrored = bare(-1),
              rotated{AnalyticScene::room({-2.0, -0.7, -0.8}, {1.0, 0.8, 1.2}), 0, 0};
  const AnalyticScene hall = AnalyticScene::room({-0.9, -0.7, -1}, {0.9, 0.8, 2});
  const Place with_box{hall.with(Box{{0.3, 0.1, 1.1}, {0.95, 0.85, 1.7}}), 0, 0},
      with_mirrored_box{hall.with(Box{{-0.95, 0.1, 1.1}, {-0.3, 0.85, 1.7}}), 0, 0};
  using Pair = std::pair<const Place*, const Place*>;
  for (const auto& [known, other] :
       {Pair{&room, &mirrored}, Pair{&room, &rotated}, Pair{&with_box, &with_mirrored_box}}) {
    Mission mission(kCoarse);
    mission.tolerance_deg = 1;
    mission.tolerance_m = 0.03;
    int tick = 0;
    for (; tick < 6; ++tick)
      EXPECT_EQ(mission.see(*known, stroll(0.3 * tick), tick).status, TrackingStatus::kGood);
    for (; tick < 12; tick += 3) mission.see_nothing(tick);
    for (; tick < 42; tick += 3)
      EXPECT_NE(mission.see(*other, stroll(1.5), tick).status, TrackingStatus::kGood);
  }
}

// A wall tells a distance and two tilts: how far the camera has gone along it meanwhile, nobody knows.
TEST(Recovery, AfterABlackoutABareWallTellsTooLittle) {
  const Place place{
      AnalyticScene({Plane{{0, 0, -1}, -2.0}, Box{{-1.2, 0.15, 1.0}, {-0.5, 0.6, 2.1}},
                     Box{{-1.2, -0.9, 1.0}, {-0.55, -0.5, 2.1}}, Sphere{{-0.55, -0.35, 1.5}, 0.25}}),
      0, 0};
  Mission mission(kCoarse);
  mission.tolerance_deg = 1;
  int tick = 0;
  for (; tick < 5; ++tick)
    EXPECT_EQ(mission.see(place, Pose::Identity(), tick).status, TrackingStatus::kGood);
  EXPECT_EQ(mission.last().quality.free_directions, 0);
  for (; tick < 25; ++tick) mission.see_nothing(tick);
  for (; tick < 30; ++tick) {
    EXPECT_EQ(mission.see(place, pose_of({0, 0, 0}, {0.8, 0, 0}), tick).status, TrackingStatus::kUncertain);
    EXPECT_EQ(mission.last().cause, TrackingCause::kUnconstrained);
  }
  EXPECT_EQ(mission.see(place, pose_of({0, 0, 0}, {0.03, 0, 0}), tick).status, TrackingStatus::kGood);
}

// What one segment left to the motion model is no debt of the next.
TEST(Recovery, ANewSegmentMayBeginAtABareWall) {
  const Place far{AnalyticScene({Plane{{0, 0, -1}, -2.0}}), 0, 0},
      near{AnalyticScene({Plane{{0, 0, -1}, -1.0}}), 0, 0};
  CollectorConfig config = recovery_config();
  config.tracking.new_segment_after_s = 0.3;
  Mission mission(kCoarse, config);
  mission.tolerance_deg = 3;
  mission.tolerance_m = 1;  // along the wall
  int tick = 0;
  for (; tick < 19; ++tick) mission.see(far, Pose::Identity(), tick);
  EXPECT_EQ(mission.last().cause, TrackingCause::kUnconstrained);
  for (; tick < 60 && mission.last().segment == 0; ++tick) mission.see(near, Pose::Identity(), tick);
  ASSERT_EQ(mission.last().source, PoseSource::kStart);
  for (int k = 0; k < 5; ++k)
    EXPECT_EQ(mission.see(near, Pose::Identity(), tick++).status, TrackingStatus::kGood) << k;
}

}  // namespace
}  // namespace kt::test
