// Drift is taken out by loop closures, segments are joined, and what nothing closes stays as it is.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/placement/place_mission.h"

#include <numbers>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

#include "onboard/loops/keyframe_maker.h"
#include "tests/support/analytic_scene.h"
#include "tests/support/pose_matchers.h"

namespace kt::test {
namespace {

constexpr int kTurn = 18, kFrames = 40;
const Calibration kCalibration = small_calibration(2);

Pose T_true(int i) { return pose_of({0, 20.0 * i, 0}, {0.01 * (i % kTurn), 0, 0.02 * (i / kTurn)}); }

// A camera that turns twice and some more; its odometry turns by a little too much. From frame `cut` on it is
// a segment of its own, in a frame of its own.
Session turning(int cut = kFrames) {
  Session session;
  session.header.calibration = kCalibration;
  Preprocessor preprocessor(exec::Device::cpu(1), kCalibration, {});
  KeyframeMaker maker(kCalibration, PlaceFeature::kSurf);
  const auto drifted = [](int i) { return pose_of({0, 0.15 * i, 0}, {0.003 * i, 0, 0}) * T_true(i); };
  for (int i = 0; i < kFrames; ++i) {
    const RgbdFrame frame =
        render(furnished_room(), kCalibration, T_true(i), {.sequence = i, .blotches_m = 0.12});
    StampedPose pose;
    pose.sequence = i;
    pose.timestamp_us = frame.timestamp_us;
    pose.segment = i >= cut;
    pose.from_sequence = i == cut ? i : std::max(0, i - 1);
    pose.T_odom_camera = i < cut ? drifted(i) : drifted(cut).inverse() * drifted(i);
    pose.information = 1e4 * Matrix6d::Identity();
    session.trajectory.push_back(pose);
    session.keyframes.push_back(
        maker.make(KeyframeMaker::images_of(preprocessor.process(frame), frame.colour, pose)));
  }
  return session;
}

double largest_error_m(const PlacedMission& placed) {
  double largest = 0;
  for (int i = 0; i < kFrames; ++i) {
    const Pose T_error = T_true(0).inverse() * T_true(i) *
                         placed.T_world_camera[static_cast<size_t>(i)].inverse() * placed.T_world_camera[0];
    largest = std::max(largest, T_error.translation().norm() + rotation_angle(T_error));
  }
  return largest;
}

const std::function<void(double)> kNobody = [](double) {};

PlacedMission place_mission(const Session& session, const LoopOptions& config,
                            const std::function<void(double)>& progress) {
  std::vector<LoopClosure> candidates = find_loops(session, config, 0, progress);
  MissionGraph measured = mission_graph(session.trajectory, candidates);
  OptimisedGraph solution = solve_mission(measured, {});
  return placed_mission(session, std::move(candidates), std::move(measured), std::move(solution));
}

TEST(PlaceMission, ClosuresTakeTheDriftOut) {
  const Session session = turning();
  const PlacedMission odometry = place_mission(session, {.source = LoopSource::kNone}, kNobody);
  EXPECT_FALSE(odometry.is_optimised());
  for (size_t i = 0; i < odometry.T_world_camera.size(); ++i)
    EXPECT_EQ(odometry.T_world_camera[i].matrix(), session.trajectory[i].T_odom_camera.matrix());
  std::vector<double> shares;
  const PlacedMission placed = place_mission(session, {}, [&](double share) { shares.push_back(share); });
  EXPECT_TRUE(placed.is_optimised());
  EXPECT_EQ(placed.T_world_camera[0].matrix(), session.trajectory[0].T_odom_camera.matrix());
  EXPECT_LT(largest_error_m(placed), 0.3 * largest_error_m(odometry));
  EXPECT_TRUE(std::is_sorted(shares.begin(), shares.end()));
  EXPECT_THAT(placed.group, testing::Each(0));
}

TEST(PlaceMission, SegmentsAreJoinedByTheirClosures) {
  const Session session = turning(kTurn);
  const PlacedMission apart = place_mission(session, {.source = LoopSource::kNone}, kNobody);
  EXPECT_EQ(apart.group.front(), 0);
  EXPECT_EQ(apart.group.back(), 1);
  const PlacedMission joined = place_mission(session, {}, kNobody);
  EXPECT_THAT(joined.group, testing::Each(0));
  EXPECT_LT(largest_error_m(joined), 0.1);
}

TEST(PlaceMission, TheCollectorsClosuresServeToo) {
  Session session = turning();
  EXPECT_FALSE(place_mission(session, {.source = LoopSource::kLog}, kNobody).is_optimised());
  session.loop_closures = place_mission(session, {}, kNobody).candidates;
  const PlacedMission placed = place_mission(session, {.source = LoopSource::kLog}, kNobody);
  EXPECT_TRUE(placed.is_optimised());
  EXPECT_LT(largest_error_m(placed), 0.1);
}

TEST(PlaceMission, WithoutTheSessionEventOdometryStands) {
  Session session = turning();
  session.integrity.session_missing = true;
  EXPECT_FALSE(place_mission(session, {}, kNobody).is_optimised()) << "nobody knows the camera";
}

TEST(PlaceMission, AKeyframeWithoutItsPoseIsLeftOut) {
  Session session = turning();
  session.trajectory.erase(session.trajectory.begin() + 20);
  const PlacedMission placed = place_mission(session, {}, kNobody);
  for (const LoopClosure& loop : placed.candidates) EXPECT_TRUE(loop.from != 20 && loop.to != 20);
  EXPECT_EQ(placed.T_world_camera.size(), session.trajectory.size());
  EXPECT_THAT(placed.group, testing::Each(0));
}

}  // namespace
}  // namespace kt::test
