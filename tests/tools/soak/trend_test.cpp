// Tests of the line through samples.
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/soak/trend.h"

#include <gtest/gtest.h>

namespace kt {
namespace {

TEST(Trend, FindsTheLineAmongNoise) {
  Trend trend;
  for (int i = 0; i < 100; ++i) trend.add(10 + i, 5 + 0.25 * i + (i % 2 ? 1 : -1));
  EXPECT_NEAR(trend.slope(), 0.25, 0.002);
  EXPECT_NEAR(trend.growth(), 24.75, 0.2);
  EXPECT_NEAR(trend.median(), 17.5, 1.5);
  EXPECT_DOUBLE_EQ(trend.maximum(), 5 + 0.25 * 99 + 1);
}

TEST(Trend, OfTooLittleThereIsNone) {
  Trend trend;
  EXPECT_EQ(trend.growth(), 0);
  EXPECT_EQ(trend.median(), 0);
  trend.add(3, 7);
  EXPECT_EQ(trend.slope(), 0);
  EXPECT_EQ(trend.median(), 7);
  trend.add(3, 9);
  EXPECT_EQ(trend.slope(), 0) << "at one time";
}

}  // namespace
}  // namespace kt
