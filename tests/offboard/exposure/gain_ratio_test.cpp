// Tests of the robust ratio of two views.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/exposure/gain_ratio.h"

#include "gtest/gtest.h"

#include "shared/core/rng.h"

namespace kt {
namespace {

// `count` ratios around log_ratio with sigma 0.05, `wrong` of them off by a half.
LogRatios ratios_around(double log_ratio, uint64_t count, uint64_t wrong = 0) {
  LogRatios ratios;
  for (uint64_t i = 0; i < count; ++i)
    ratios[0].push_back(static_cast<float>(log_ratio + (i < wrong ? 0.5 : 0.05 * random_normal(7, 0, i))));
  return ratios;
}

TEST(GainRatio, IsTheMedianWithItsUncertainty) {
  const GainRatio ratio = gain_ratio(ratios_around(0.2, 2000));
  ASSERT_TRUE(ratio[0]);
  EXPECT_NEAR(ratio[0]->log_ratio, 0.2, 0.005);
  // 200 independent cells of sigma 0.05: 1.25 * 0.05 / sqrt(200), and what cells share.
  EXPECT_NEAR(ratio[0]->sigma, std::hypot(0.005, 0.0044), 0.0005);
  EXPECT_FALSE(ratio[1]);
}

TEST(GainRatio, AQuarterOfWrongCellsDoesLittle) {
  EXPECT_NEAR(gain_ratio(ratios_around(-0.3, 2000, 500))[0]->log_ratio, -0.3, 0.03);
}

TEST(GainRatio, FewCellsSayNothing) {
  EXPECT_FALSE(gain_ratio(ratios_around(0, kMinCells - 1))[0]);
  EXPECT_TRUE(gain_ratio(ratios_around(0, kMinCells))[0]);
}

TEST(GainRatio, DisagreementIsTheMedianDistanceFromWhatIsExpected) {
  LogRatios ratios;
  for (int i = 0; i < 101; ++i) {
    ratios[0].push_back(0.1f);
    ratios[2].push_back(0.001f * static_cast<float>(i));
  }
  EXPECT_NEAR(*disagreement(ratios, {0, 9, 0}), (0.1 + 0.05) / 2, 1e-6);
  EXPECT_NEAR(*disagreement(ratios, {0.1, 9, 0.05}), (0 + 0.025) / 2, 1e-6);
  EXPECT_FALSE(disagreement({}, {}));
}

}  // namespace
}  // namespace kt
