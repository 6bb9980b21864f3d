// Tests of the counter-based random numbers: fixed values, moments, independence.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/core/rng.h"

#include <array>
#include <bit>
#include <cmath>
#include <set>

#include "gtest/gtest.h"

namespace kt {
namespace {

TEST(Rng, GivesTheSameNumbersOnEveryMachine) {
  EXPECT_EQ(random_bits(0, 0, 0), 0x46b73e79f0c37c00u);
  EXPECT_EQ(random_bits(1, 2, 3), 0xf8006e8a15981575u);
  EXPECT_EQ(random_bits(~uint64_t{0}, 7, uint64_t{1} << 40), 0x97712950c14591b1u);
  EXPECT_EQ(random_uniform(1, 2, 3), 0.9687565886611937);
  EXPECT_EQ(random_normal(1, 2, 3), -0x1.204cp-1);
}

TEST(Rng, UniformHasItsMomentsAndStaysInRange) {
  constexpr int kCount = 200'000;
  double sum = 0, squares = 0;
  std::array<int, 16> histogram{};
  for (uint64_t i = 0; i < kCount; ++i) {
    const double x = random_uniform(42, 1, i);
    ASSERT_GE(x, 0);
    ASSERT_LT(x, 1);
    sum += x;
    squares += x * x;
    ++histogram[static_cast<size_t>(x * 16)];
  }
  const double mean = sum / kCount;
  EXPECT_NEAR(mean, 0.5, 4 * std::sqrt(1.0 / 12 / kCount));
  EXPECT_NEAR(squares / kCount - mean * mean, 1.0 / 12, 1e-3);
  for (const int bin : histogram) EXPECT_NEAR(bin, kCount / 16, 5 * std::sqrt(kCount / 16.0));
}

TEST(Rng, NormalHasItsMoments) {
  constexpr int kCount = 200'000;
  double sum = 0, squares = 0, fourth = 0;
  for (uint64_t i = 0; i < kCount; ++i) {
    const double x = random_normal(7, 3, i);
    ASSERT_LE(std::abs(x), 6);
    sum += x;
    squares += x * x;
    fourth += x * x * x * x;
  }
  EXPECT_NEAR(sum / kCount, 0, 4 / std::sqrt(kCount));
  EXPECT_NEAR(squares / kCount, 1, 0.02);
  EXPECT_NEAR(fourth / kCount, 2.9, 0.1);  // 3 - 1.2 / 12 for the sum of 12 uniforms
}

TEST(Rng, SeedsStreamsAndCountersDoNotCollide) {
  std::set<uint64_t> seen;
  for (uint64_t seed = 0; seed < 20; ++seed) {
    for (uint64_t stream = 0; stream < 20; ++stream) {
      for (uint64_t counter = 0; counter < 100; ++counter) seen.insert(random_bits(seed, stream, counter));
    }
  }
  EXPECT_EQ(seen.size(), 20u * 20u * 100u);
}

// Neighbouring numbers along each of the three arguments.
TEST(Rng, NeighboursAreIndependent) {
  constexpr int kCount = 50'000;
  const double bound = 5 / std::sqrt(kCount);
  std::array<double, 3> correlation{}, flipped_bits{};
  for (uint64_t i = 0; i < kCount; ++i) {
    const uint64_t seed = i % 10, stream = i / 10 % 10, counter = i / 100;
    const uint64_t here = random_bits(seed, stream, counter);
    const std::array<uint64_t, 3> next{random_bits(seed + 1, stream, counter),
                                       random_bits(seed, stream + 1, counter),
                                       random_bits(seed, stream, counter + 1)};
    for (size_t k = 0; k < 3; ++k) {
      const auto centred = [](uint64_t bits) { return static_cast<double>(bits >> 11) * 0x1p-53 - 0.5; };
      correlation[k] += 12 * centred(here) * centred(next[k]) / kCount;
      flipped_bits[k] += static_cast<double>(std::popcount(here ^ next[k])) / kCount;
    }
  }
  for (size_t k = 0; k < 3; ++k) {
    EXPECT_NEAR(correlation[k], 0, bound) << "argument " << k;
    EXPECT_NEAR(flipped_bits[k], 32, 4 * bound) << "argument " << k;
  }
}

}  // namespace
}  // namespace kt
