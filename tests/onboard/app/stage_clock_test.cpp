// Tests of the percentiles of durations.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/app/stage_clock.h"

#include <stdexcept>
#include <thread>

#include "gtest/gtest.h"

namespace kt {
namespace {

TEST(StageClock, PercentilesAreExactToOnePercent) {
  StageClock clock;
  for (int k = 0; k < 1000; ++k) clock.add("even", 1 + (k * 617) % 1000);  // 1 to 1000 ms, mixed
  const StageTimes times = clock.times().at("even");
  EXPECT_NEAR(times.p50_ms, 500, 5);
  EXPECT_NEAR(times.p95_ms, 950, 9.5);
  EXPECT_EQ(times.max_ms, 1000);
  EXPECT_EQ(times.count, 1000);
}

TEST(StageClock, OfOneValueIsThatValue) {
  for (const double milliseconds : {0.002, 0.5, 33.3, 1234.5}) {
    StageClock clock;
    clock.add("once", milliseconds);
    const StageTimes times = clock.times().at("once");
    EXPECT_NEAR(times.p50_ms, milliseconds, 0.01 * milliseconds);
    EXPECT_LE(times.p95_ms, milliseconds) << "no percentile above the maximum";
    EXPECT_EQ(times.max_ms, milliseconds);
  }
}

TEST(StageClock, SurvivesExtremes) {
  StageClock clock;
  for (const double milliseconds : {-5.0, 0.0, 1e-9, 1e12}) clock.add("odd", milliseconds);
  EXPECT_EQ(clock.times().at("odd").count, 4);
  EXPECT_EQ(clock.times().at("odd").max_ms, 1e12);
}

TEST(StageClock, KeepsStagesApartAndSorted) {
  StageClock clock;
  clock.add("track", 5);
  clock.add("fuse", 7);
  clock.add("track", 6);
  const auto times = clock.times();
  ASSERT_EQ(times.size(), 2u);
  EXPECT_EQ(times.begin()->first, "fuse");
  EXPECT_EQ(times.at("track").count, 2);
}

TEST(StageClock, RecentTimesAreExactAndForgotten) {
  StageClock clock;
  EXPECT_EQ(clock.recent("track").count, 0);
  for (const double ms : {5.0, 1.0, 3.0, 2.0}) clock.add("track", ms);
  EXPECT_EQ(clock.recent("track").p50_ms, 2);
  EXPECT_EQ(clock.recent("track").p95_ms, 5);
  EXPECT_EQ(clock.recent("track").max_ms, 5);
  clock.forget_recent();
  EXPECT_EQ(clock.recent("track").count, 0);
  EXPECT_EQ(clock.recent("track").max_ms, 0);
  clock.add("track", 7);
  EXPECT_EQ(clock.recent("track").p50_ms, 7);
  for (int i = 0; i < 1000; ++i) clock.add("track", i);
  EXPECT_EQ(clock.recent("track").count, 64) << "the last ones";
  EXPECT_EQ(clock.recent("track").max_ms, 999);
  EXPECT_EQ(clock.times().at("track").count, 1005) << "all of the mission";
}

TEST(StageClock, SaysWhatItBookedLast) {
  StageClock clock;
  clock.add("track", 5);
  clock.add("fuse", 7.25);
  EXPECT_EQ(clock.last_ms(), 7.25);
  clock.measure("body", [&] { clock.add("part of it", 1e6); });
  EXPECT_LT(clock.last_ms(), 1e6) << "the whole is booked after its parts";
}

TEST(StageClock, MeasurePassesTheResultOn) {
  StageClock clock;
  int value = 3;
  int& same = clock.measure("body", [&]() -> int& {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
    return value;
  });
  EXPECT_EQ(&same, &value);
  EXPECT_GE(clock.times().at("body").max_ms, 5);
}

TEST(StageClock, BooksABodyThatThrows) {
  StageClock clock;
  EXPECT_THROW(clock.measure("body", []() { throw std::runtime_error("no"); }), std::runtime_error);
  EXPECT_EQ(clock.times().at("body").count, 1);
}

}  // namespace
}  // namespace kt
