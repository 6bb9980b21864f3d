// A walk along a wall and back, whose revisits are known, and loops of every kind held against it.
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/eval/loop_evaluation.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/test_files.h"
#include "tests/tools/eval/wall_views.h"
#include "tools/eval/report.h"

namespace kt {
namespace {

using ::testing::HasSubstr;

struct LoopWalk {
  Session session;
  Trajectory truth;

  LoopEvaluation evaluated() const { return evaluate_loops(session, truth); }
  Keyframe& keyframe(size_t k) { return session.keyframes[k]; }
  Pose T(size_t from, size_t to) const {
    return truth[2 * from].T_odom_camera.inverse() * truth[2 * to].T_odom_camera;
  }
  // `error` on the right of the true motion.
  void propose(size_t from, size_t to, LoopVerdict verdict = LoopVerdict::kAccepted,
               const Vector6d& error = Vector6d::Zero()) {
    LoopClosure loop;
    loop.sequence = static_cast<int64_t>(session.loop_closures.size());
    loop.from = session.keyframes[from].sequence;
    loop.to = session.keyframes[to].sequence;
    loop.T_from_to = T(from, to) * exp_se3(error);
    loop.verdict = verdict;
    session.loop_closures.push_back(loop);
  }
};

// Keyframe k is frame 10 k. Steps of 30 cm along the wall: 0 at 0 m, 10 at 3 m, 20 back at 0 m. At a side
// step d the overlap is 1 - d / 2.56 m: at least 50 % up to 1.28 m, but a revisit is within 1 m; below 20 %
// beyond 2.05 m. So the revisits are those of 17 to 20, at 0.9 to 0 m: the others have not been away since.
// The ground truth begins elsewhere, and has a pose between any two keyframes.
LoopWalk there_and_back() {
  const Pose T_truth_wall = exp_se3((Vector6d() << 1, -2, 0.5, 10, 20, -30).finished());
  LoopWalk walk;
  walk.session.header.calibration = wall_calibration();
  for (int k = 0; k <= 40; ++k) {
    const double x = 0.15 * (k <= 20 ? k : 40 - k);
    walk.truth.push_back(
        {.sequence = k, .timestamp_us = 100'000 * k, .T_odom_camera = T_truth_wall * facing_wall(x)});
    if (k % 2 == 1) continue;
    Keyframe keyframe;
    keyframe.sequence = 5 * k;
    keyframe.timestamp_us = 100'000 * k;
    keyframe.depth = wall_depth();
    walk.session.keyframes.push_back(keyframe);
  }
  return walk;
}

Vector6d error_of_pose(double translation_m, double rotation_deg = 0) {
  Vector6d xi = Vector6d::Zero();
  xi[1] = rotation_deg * 3.14159265358979 / 180;
  xi[4] = translation_m;
  return xi;
}

TEST(LoopEvaluation, FindsTheRevisitsOfAWalkThereAndBack) {
  const LoopEvaluation loops = there_and_back().evaluated();
  EXPECT_EQ(loops.keyframes, 21);
  EXPECT_EQ(loops.keyframes_left_out, 0);
  EXPECT_EQ(loops.revisit_keyframes, 4);
  EXPECT_EQ(loops.unproposed_keyframes, 4);
  EXPECT_EQ(loops.recalled_keyframes, 0);
  ASSERT_EQ(loops.events.size(), 1u);
  EXPECT_EQ(loops.events[0].first, 170);
  EXPECT_EQ(loops.events[0].last, 200);
  EXPECT_EQ(loops.events[0].keyframes, 4);
  EXPECT_FALSE(loops.events[0].is_recalled);
  EXPECT_FALSE(loops.precision());
}

TEST(LoopEvaluation, AnEventEndsAfterTwoKeyframesWithoutARevisit) {
  // What 18, and then 19 too, see is nearer than all that was seen before.
  LoopWalk walk = there_and_back();
  walk.keyframe(18).depth = wall_depth(0.5);
  EXPECT_EQ(walk.evaluated().events.size(), 1u);
  EXPECT_EQ(walk.evaluated().events[0].keyframes, 3);
  walk.keyframe(19).depth = wall_depth(0.5);
  const LoopEvaluation loops = walk.evaluated();
  ASSERT_EQ(loops.events.size(), 2u);
  EXPECT_EQ(loops.events[0].first, 170);
  EXPECT_EQ(loops.events[0].last, 170);
  EXPECT_EQ(loops.events[1].first, 200);
  EXPECT_EQ(loops.events[1].last, 200);
}

TEST(LoopEvaluation, ARevisitIsNearInDistanceAndAngle) {
  LoopWalk walk = there_and_back();
  for (size_t k = 34; k <= 40; ++k) {
    Pose& T = walk.truth[k].T_odom_camera;
    T = T * exp_se3((Vector6d() << 0, 0, 0.71, 0, 0, 0).finished());  // 41 degrees about the line of sight
  }
  EXPECT_EQ(walk.evaluated().revisit_keyframes, 0);
  for (size_t k = 34; k <= 40; ++k) {
    Pose& T = walk.truth[k].T_odom_camera;
    T = T * exp_se3((Vector6d() << 0, 0, -0.03, 0, 0, 0).finished());  // 39 degrees
  }
  EXPECT_GT(walk.evaluated().revisit_keyframes, 0);
}

TEST(LoopEvaluation, JudgesClosuresByTheirPose) {
  LoopWalk walk = there_and_back();
  walk.propose(0, 20);
  walk.propose(3, 17, LoopVerdict::kAccepted, error_of_pose(0.049, 2.9));
  walk.propose(1, 19, LoopVerdict::kAccepted, error_of_pose(0.051));
  walk.propose(2, 18, LoopVerdict::kAccepted, error_of_pose(0, 3.1));
  const LoopEvaluation loops = walk.evaluated();
  EXPECT_EQ(loops.accepted(), 4);
  ASSERT_EQ(loops.judged.size(), 4u);
  EXPECT_EQ(loops.correct(), 2);
  EXPECT_DOUBLE_EQ(*loops.precision(), 0.5);
  EXPECT_NEAR(loops.judged[0].translation_m, 0, 1e-9);
  EXPECT_NEAR(loops.judged[1].rotation_deg, 2.9, 1e-6);
  EXPECT_TRUE(loops.judged[1].is_correct);
  EXPECT_EQ(loops.judged[2].from, 10);
  EXPECT_EQ(loops.judged[2].to, 190);
  EXPECT_NEAR(loops.judged[2].translation_m, 0.051, 1e-9);
  EXPECT_FALSE(loops.judged[2].is_correct);
  EXPECT_FALSE(loops.judged[3].is_correct);
  EXPECT_NEAR(loops.translation_m()->max, 0.051, 1e-9);
  EXPECT_NEAR(loops.rotation_deg()->max, 3.1, 1e-6);
  EXPECT_EQ(loops.recalled_keyframes, 2) << "a wrong closure recalls nothing";
  EXPECT_EQ(loops.recalled_events(), 1);
}

TEST(LoopEvaluation, ACorrectClosureOfALesserOverlapRecallsTheEvent) {
  LoopWalk walk = there_and_back();
  walk.propose(4, 20);  // 1.2 m apart
  LoopEvaluation loops = walk.evaluated();
  EXPECT_EQ(loops.revisits_by_verdict[0], 0);
  EXPECT_EQ(loops.recalled_keyframes, 1);
  EXPECT_EQ(loops.recalled_events(), 1);

  walk.session.loop_closures.clear();
  walk.propose(5, 15);  // correct, but of no event
  loops = walk.evaluated();
  EXPECT_EQ(loops.correct(), 1);
  EXPECT_EQ(loops.recalled_events(), 0);
}

TEST(LoopEvaluation, TellsWhyRevisitsWereMissed) {
  LoopWalk walk = there_and_back();
  walk.propose(0, 20, LoopVerdict::kTooFewMatches);
  walk.propose(1, 20, LoopVerdict::kLittleOverlap);
  walk.propose(9, 20, LoopVerdict::kTooFewMatches);  // rightly
  walk.propose(3, 18, LoopVerdict::kLittleOverlap);
  walk.propose(2, 12, LoopVerdict::kWeak);  // no revisit at all
  const LoopEvaluation loops = walk.evaluated();
  EXPECT_EQ(loops.candidates(), 5);
  EXPECT_THAT(loops.by_verdict, ::testing::ElementsAre(0, 2, 0, 0, 2, 0, 0, 1));
  EXPECT_THAT(loops.revisits_by_verdict, ::testing::ElementsAre(0, 1, 0, 0, 2, 0, 0, 0));
  EXPECT_EQ(loops.unproposed_keyframes, 2) << "17 and 19";
}

TEST(LoopEvaluation, KeyframesWithoutTruthOrDepthTakeNoPart) {
  LoopWalk walk = there_and_back();
  walk.propose(0, 20);
  walk.propose(1, 19);
  walk.propose(2, 18);
  walk.keyframe(20).depth = {};
  walk.keyframe(19).timestamp_us += 1'000'000'000;
  walk.session.loop_closures[2].from = 21;  // a frame that is no keyframe
  const LoopEvaluation loops = walk.evaluated();
  EXPECT_EQ(loops.keyframes_left_out, 2);
  EXPECT_EQ(loops.revisit_keyframes, 2);
  EXPECT_EQ(loops.accepted(), 3);
  EXPECT_TRUE(loops.judged.empty());
}

TEST(LoopEvaluation, ALogWithoutKeyframesCountsNothing) {
  LoopWalk walk = there_and_back();
  walk.propose(0, 20);
  walk.session.keyframes.clear();
  const LoopEvaluation loops = walk.evaluated();
  EXPECT_EQ(loops.keyframes, 0);
  EXPECT_EQ(loops.accepted(), 1);
  EXPECT_TRUE(loops.events.empty());
  const auto json = loops_json(loops);
  EXPECT_TRUE(json["precision"].is_null());
  EXPECT_TRUE(json["error"].is_null());
  EXPECT_TRUE(json["revisits"]["recall"].is_null());
  EXPECT_THAT(loops_text(loops), HasSubstr("0 of 0 events"));
}

TEST(LoopEvaluation, WhatCannotBeJudgedIsNamed) {
  LoopWalk walk = there_and_back();
  const auto error = [&] { return error_of([&] { walk.evaluated(); }); };
  walk.keyframe(5).depth = Image<uint16_t>(80, 60);
  EXPECT_THAT(error(), HasSubstr("depth image of keyframe 50 is 80 x 60, a quarter of the session's depth "
                                 "camera is 160 x 120"));
  walk = there_and_back();
  for (StampedPose& pose : walk.truth) pose.timestamp_us += 1'000'000'000;
  EXPECT_THAT(error(), HasSubstr("no keyframe of the log has a ground truth"));
  walk.session.integrity.session_missing = true;
  EXPECT_THAT(error(), HasSubstr("no session event"));
}

TEST(LoopEvaluation, IsReported) {
  LoopWalk walk = there_and_back();
  walk.propose(0, 20);
  walk.propose(1, 19, LoopVerdict::kAccepted, error_of_pose(0.2));
  walk.propose(3, 17, LoopVerdict::kUnconstrained);
  const LoopEvaluation loops = walk.evaluated();
  const auto json = loops_json(loops);
  EXPECT_EQ(json["candidates"], 3);
  EXPECT_EQ(json["by_verdict"]["accepted"], 2);
  EXPECT_EQ(json["by_verdict"]["too few matches"], 0);
  EXPECT_EQ(json["precision"], 0.5);
  EXPECT_NEAR(json["error"]["translation"]["max_m"], 0.2, 1e-9);
  EXPECT_EQ(json["revisits"]["keyframes"], 4);
  EXPECT_EQ(json["revisits"]["recall"], 0.25);
  EXPECT_EQ(json["revisits"]["unproposed"], 1);
  EXPECT_EQ(json["revisits"]["by_verdict"]["unconstrained"], 1);
  EXPECT_EQ(json["events"]["recalled"], 1);
  EXPECT_EQ(json["events"]["list"][0]["first"], 170);
  ASSERT_EQ(json["wrong"].size(), 1u);
  EXPECT_EQ(json["wrong"][0]["to"], 190);
  const std::string text = loops_text(loops);
  EXPECT_THAT(text, HasSubstr("1 of 1 events recalled, 1 of 4 keyframes"));
  EXPECT_THAT(text, HasSubstr("2 accepted, 1 unconstrained"));
  EXPECT_THAT(text, HasSubstr("frames 10 and 190: 200.0 mm"));
}

}  // namespace
}  // namespace kt
