// Stamps of a mission over clocks that step, in either direction.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/source/stamp_clock.h"

#include <gtest/gtest.h>

namespace kt {
namespace {

constexpr int64_t kWall_us = 1'700'000'000'000'000;

TEST(StampClock, BeginsAtTheWallClockAndFollowsTheDevice) {
  StampClock clock;
  EXPECT_EQ(clock.stamp(0, 5'000, 100, kWall_us).us, kWall_us);
  EXPECT_EQ(clock.stamp(1, 6'000, 900, kWall_us).us, kWall_us + 1'000);
  EXPECT_EQ(clock.stamp(0, 38'000, 33'100, kWall_us).us, kWall_us + 33'000);
  EXPECT_EQ(clock.stamp(1, 37'000, 33'500, kWall_us).us, kWall_us + 32'000)
      << "streams may come out of order";
}

TEST(StampClock, AStepOfTheWallClockChangesNothing) {
  StampClock clock;
  clock.stamp(0, 0, 0, kWall_us);
  EXPECT_EQ(clock.stamp(0, 33'000, 33'000, kWall_us - 3'600'000'000).us, kWall_us + 33'000);
  EXPECT_EQ(clock.stamp(0, 66'000, 66'000, kWall_us + 3'600'000'000).us, kWall_us + 66'000);
}

TEST(StampClock, AStepOfTheDeviceIsBridgedByTheSteadyClock) {
  for (const int64_t step_us : {-3'600'000'000LL, -10'000'000LL, -50'000LL, 10'000'000LL, 3'600'000'000LL}) {
    StampClock clock;
    int64_t device_us = 4'000'000'000, steady_us = 77;
    int64_t last_us = clock.stamp(0, device_us, steady_us, kWall_us).us;
    for (int i = 1; i < 9; ++i) {
      device_us += 33'000 + (i == 4 ? step_us : 0);
      steady_us += 33'000;
      for (const int stream : {0, 1}) {
        const auto stamp = clock.stamp(stream, device_us, steady_us, kWall_us);
        EXPECT_EQ(stamp.us, last_us + (stream == 0 ? 33'000 : 0)) << step_us << " " << i;
        last_us = stamp.us;
      }
    }
  }
}

TEST(StampClock, SettlesAfterALateImageOfTheOldClock) {
  StampClock clock;
  clock.stamp(0, 5'000'000'000, 0, kWall_us);
  EXPECT_TRUE(clock.stamp(0, 1'000, 33'000, kWall_us).is_stepped);
  EXPECT_TRUE(clock.stamp(1, 5'000'030'000, 40'000, kWall_us).is_stepped);
  int64_t last_us = clock.stamp(0, 34'000, 66'000, kWall_us).us;
  for (int i = 2; i < 6; ++i) {
    const auto stamp = clock.stamp(i % 2, 34'000 + 20'000 * i, 66'000 + 20'000 * i, kWall_us);
    EXPECT_FALSE(stamp.is_stepped);
    EXPECT_GT(stamp.us, last_us);
    EXPECT_LT(stamp.us - kWall_us, 1'000'000);
    last_us = stamp.us;
  }
}

TEST(StampClock, AnInterruptionLastsAsLongAsItDid) {
  StampClock clock;
  clock.stamp(0, 9'000'000, 0, kWall_us);
  clock.interrupt();
  EXPECT_EQ(clock.stamp(0, 0, 60'000'000, kWall_us - 5).us, kWall_us + 60'000'000);
}

}  // namespace
}  // namespace kt
