// The rule by which a late mission does less per frame, and more again.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/app/effort_control.h"

#include <gtest/gtest.h>

namespace kt {
namespace {

constexpr double kInterval_s = 1.0 / 30;

/// Adds frames until the effort changes; how many that took, -1 where it does not within a day.
int frames_until_change(EffortControl& control, int waiting, double worked_share) {
  const Effort before = control.effort();
  for (int i = 1; i < 1'000'000; ++i) {
    control.add(waiting, worked_share * kInterval_s, kInterval_s);
    if (control.effort() != before) return i;
  }
  return -1;
}

TEST(EffortControl, DoesLessWhereFramesPileUpStepByStep) {
  EffortControl control;
  EXPECT_EQ(frames_until_change(control, 3, 1), 10);
  EXPECT_EQ(control.effort(), Effort::kSparseFusion);
  EXPECT_EQ(frames_until_change(control, 30, 1), 10);
  EXPECT_EQ(control.effort(), Effort::kCoarseTracking);
  EXPECT_EQ(frames_until_change(control, 30, 1), -1) << "there is no less";
}

TEST(EffortControl, AHiccupChangesNothing) {
  EffortControl control;
  for (int i = 0; i < 1000; ++i) control.add(i % 10 == 9 ? 2 : 20, kInterval_s, kInterval_s);
  EXPECT_EQ(control.effort(), Effort::kFull);
}

TEST(EffortControl, DoesMoreOnlyWithTimeToSpare) {
  EffortControl control;
  frames_until_change(control, 30, 1);
  EXPECT_EQ(frames_until_change(control, 0, 0.61), -1);
  EXPECT_EQ(frames_until_change(control, 2, 0.1), -1) << "two frames wait";
  EXPECT_EQ(frames_until_change(control, 1, 0.59), 90);
  EXPECT_EQ(control.effort(), Effort::kFull);
  EXPECT_EQ(frames_until_change(control, 0, 0), -1);
}

TEST(EffortControl, WhatWasGivenBackTooSoonIsGivenBackLaterNextTime) {
  EffortControl control;
  frames_until_change(control, 30, 1);
  for (const int patience : {90, 180, 360}) {
    EXPECT_EQ(frames_until_change(control, 0, 0.5), patience);
    EXPECT_EQ(frames_until_change(control, 30, 1), 10);
  }
  for (int i = 0; i < 20; ++i) {
    frames_until_change(control, 0, 0.5);
    frames_until_change(control, 30, 1);
  }
  EXPECT_EQ(frames_until_change(control, 0, 0.5), 3600) << "at most";
  // Kept up for as long, it is forgotten.
  for (int i = 0; i < 3600; ++i) control.add(0, 0, kInterval_s);
  EXPECT_EQ(frames_until_change(control, 30, 1), 10);
  EXPECT_EQ(frames_until_change(control, 0, 0.5), 90);
}

}  // namespace
}  // namespace kt
