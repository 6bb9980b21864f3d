// Estimates begin with usual rates, follow what is measured, and do not jump.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/stages/time_to_go.h"

#include <cmath>
#include <gtest/gtest.h>

namespace kt {
namespace {

TEST(TimeToGo, KnowsNothingAtFirst) {
  TimeToGo time;
  EXPECT_FALSE(time.left(0, 0).has_value());
  time.begin("load", 0);
  EXPECT_FALSE(time.left(0.5, 1).has_value());
  time.end(2, true);
  time.expect("loops", 10);
  time.expect("mesh", 30);
  time.begin("loops", 2);
  EXPECT_DOUBLE_EQ(*time.left(0, 2), 40);
}

// A machine that takes `slow` times as long as usual; what is said, second by second, against the truth.
double worst_error_share(double slow, double after_s, double* largest_jump_s) {
  TimeToGo time;
  const double expected_s[] = {20, 100, 40};
  const char* const names[] = {"loops", "fuse", "mesh"};
  for (int i = 0; i < 3; ++i) time.expect(names[i], expected_s[i]);
  double now_s = 0, worst = 0, before = -1;
  const double all_s = slow * 160;
  for (int i = 0; i < 3; ++i) {
    time.begin(names[i], now_s);
    const double stage_s = slow * expected_s[i], start_s = now_s;
    for (; now_s < start_s + stage_s; now_s += 0.5) {
      const double left_s = *time.left((now_s - start_s) / stage_s, now_s);
      if (before >= 0) *largest_jump_s = std::max(*largest_jump_s, std::abs(left_s - (before - 0.5)));
      before = left_s;
      if (now_s > after_s) worst = std::max(worst, std::abs(left_s - (all_s - now_s)) / all_s);
    }
    now_s = start_s + stage_s;
    time.end(now_s, true);
  }
  return worst;
}

TEST(TimeToGo, IsExactWhereAllIsAsUsual) {
  double jump_s = 0;
  EXPECT_LT(worst_error_share(1, 0, &jump_s), 1e-9);
  EXPECT_LT(jump_s, 1e-6);
}

TEST(TimeToGo, LearnsFromTheFirstStage) {
  for (const double slow : {0.2, 0.5, 3.0}) {
    double jump_s = 0;
    EXPECT_LT(worst_error_share(slow, slow * 20 + 30, &jump_s), 0.1) << slow;
    EXPECT_LT(jump_s, 0.12 * std::abs(slow - 1) * 160) << slow << ": what it learns it says bit by bit";
  }
}

TEST(TimeToGo, AStageThatNobodyExpectsHasItsOwnRate) {
  TimeToGo time;
  time.expect("mesh", 10);
  time.begin("new", 0);
  EXPECT_DOUBLE_EQ(*time.left(0, 0), 10);
  for (double now_s = 0; now_s < 50; ++now_s) time.left(now_s / 100, now_s);
  EXPECT_NEAR(*time.left(0.5, 50), 60, 2);
}

TEST(TimeToGo, WhatAFileSparesIsForgottenAtOnce) {
  TimeToGo time;
  time.expect("fuse", 1000);
  time.expect("mesh", 10);
  time.begin("fuse", 0);
  EXPECT_DOUBLE_EQ(*time.left(0, 0), 1010);
  time.end(1, false);
  EXPECT_DOUBLE_EQ(*time.left(1, 1), 10) << "and the machine is not taken for a fast one";
}

TEST(TimeToGo, IsSaidAsRoughlyAsItIsKnown) {
  EXPECT_EQ(rough_duration(0), "1 s");
  EXPECT_EQ(rough_duration(7.4), "7 s");
  EXPECT_EQ(rough_duration(42), "40 s");
  EXPECT_EQ(rough_duration(58), "1 min");
  EXPECT_EQ(rough_duration(190), "3 min");
  EXPECT_EQ(rough_duration(3599), "1 h");
  EXPECT_EQ(rough_duration(4700), "1 h 20 min");
  EXPECT_EQ(rough_duration(20000), "6 h");
}

}  // namespace
}  // namespace kt
