// Greedy pairing against a brute-force oracle.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/io/stamp_association.h"

#include <cstdlib>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <limits>

#include "shared/core/rng.h"

namespace kt {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

TEST(AssociateStamps, TakesTheClosestPairFirst) {
  // 100 and 110 both want 108; 110 is closer, 100 falls back on 95.
  EXPECT_THAT(associate_stamps(std::vector<int64_t>{100, 110}, std::vector<int64_t>{95, 108}, 20),
              ElementsAre(StampPair{0, 0}, StampPair{1, 1}));
  // With 95 gone, 100 has nothing left.
  EXPECT_THAT(associate_stamps(std::vector<int64_t>{100, 110}, std::vector<int64_t>{108}, 20),
              ElementsAre(StampPair{1, 0}));
}

TEST(AssociateStamps, TheWindowIsOpen) {
  EXPECT_THAT(associate_stamps(std::vector<int64_t>{0}, std::vector<int64_t>{20'000}), IsEmpty());
  EXPECT_THAT(associate_stamps(std::vector<int64_t>{0}, std::vector<int64_t>{19'999}),
              ElementsAre(StampPair{0, 0}));
}

TEST(AssociateStamps, OrderOfTheListsDoesNotMatter) {
  EXPECT_THAT(associate_stamps(std::vector<int64_t>{300, 100, 200}, std::vector<int64_t>{201, 301, 101}, 20),
              ElementsAre(StampPair{1, 2}, StampPair{2, 0}, StampPair{0, 1}));
}

TEST(AssociateStamps, AgreesWithAnExhaustiveSearch) {
  for (uint64_t seed = 0; seed < 20; ++seed) {
    std::vector<int64_t> a, b;
    for (uint64_t i = 0; i < 60; ++i) {
      a.push_back(static_cast<int64_t>(random_uniform(seed, 0, i) * 1e6) * 2);
      b.push_back(static_cast<int64_t>(random_uniform(seed, 1, i) * 1e6) * 2 + 1);  // never equal to one of a
    }
    std::vector<char> used_a(a.size()), used_b(b.size());
    std::vector<StampPair> expected;
    while (true) {
      int64_t best = kMaxStampDifference_us;
      StampPair pair;
      for (size_t i = 0; i < a.size(); ++i) {
        for (size_t j = 0; j < b.size(); ++j) {
          const int64_t difference = std::abs(a[i] - b[j]);
          const bool earlier =
              difference == best && std::pair(a[i], b[j]) < std::pair(a[pair.first], b[pair.second]);
          if (!used_a[i] && !used_b[j] && (difference < best || (earlier && best < kMaxStampDifference_us))) {
            best = difference;
            pair = {i, j};
          }
        }
      }
      if (best == kMaxStampDifference_us) break;
      used_a[pair.first] = used_b[pair.second] = 1;
      expected.push_back(pair);
    }
    EXPECT_THAT(associate_stamps(a, b), ::testing::UnorderedElementsAreArray(expected)) << "seed " << seed;
  }
}

TEST(AssociateStamps, MemoryIsLinearHoweverDenseTheStamps) {
  // Every stamp of one list is within the window of every stamp of the other: 10^10 candidates.
  std::vector<int64_t> a, b;
  for (int64_t i = 0; i < 100'000; ++i) {
    a.push_back(2 * i);
    b.push_back(2 * i + 1);
  }
  const std::vector<StampPair> pairs = associate_stamps(a, b, 1'000'000);
  ASSERT_EQ(pairs.size(), a.size());
  for (size_t i = 0; i < pairs.size(); ++i) ASSERT_EQ(pairs[i], (StampPair{i, i}));
}

}  // namespace
}  // namespace kt
