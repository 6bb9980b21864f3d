// Tests of the matching of descriptors against a search through all pairs.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/loops/descriptor_matcher.h"

#include <algorithm>
#include <bit>

#include "gtest/gtest.h"

#include "tests/onboard/loops/random_descriptors.h"

namespace kt {
inline bool operator==(const FeatureMatch& x, const FeatureMatch& y) { return x.a == y.a && x.b == y.b; }
inline void PrintTo(const FeatureMatch& match, std::ostream* out) { *out << match.a << '-' << match.b; }
}  // namespace kt

namespace kt::test {
namespace {

using Matches = std::vector<FeatureMatch>;

struct Side {
  std::vector<uint8_t> descriptors;
  std::vector<int32_t> nodes;
};

// Square of the distance, or the distance itself, by the definition.
int naive_distance(const DescriptorKind& kind, const uint8_t* a, const uint8_t* b) {
  int sum = 0;
  for (int i = 0; i < kind.bytes; ++i) {
    const int difference = static_cast<int8_t>(a[i]) - static_cast<int8_t>(b[i]);
    sum += kind.metric == DescriptorMetric::kHamming ? std::popcount(static_cast<uint8_t>(a[i] ^ b[i]))
                                                     : difference * difference;
  }
  return sum;
}

Matches naive_matches(const DescriptorKind& kind, const Side& a, const Side& b, double max_ratio) {
  const auto bytes = static_cast<size_t>(kind.bytes);
  const auto ordered = [&](const Side& side, size_t i, const Side& other) {
    std::vector<std::pair<int, int>> found;  // distance, index
    for (size_t j = 0; j < other.nodes.size(); ++j) {
      if (other.nodes[j] != side.nodes[i]) continue;
      found.emplace_back(naive_distance(kind, &side.descriptors[i * bytes], &other.descriptors[j * bytes]),
                         static_cast<int>(j));
    }
    std::sort(found.begin(), found.end());
    return found;
  };
  const double ratio = kind.metric == DescriptorMetric::kHamming ? max_ratio : max_ratio * max_ratio;
  Matches matches;
  for (size_t i = 0; i < a.nodes.size(); ++i) {
    const auto of_a = ordered(a, i, b);
    if (of_a.empty() || (of_a.size() > 1 && !(of_a[0].first < ratio * of_a[1].first))) continue;
    if (ordered(b, static_cast<size_t>(of_a[0].second), a)[0].second != static_cast<int>(i)) continue;
    matches.push_back({static_cast<int>(i), of_a[0].second});
  }
  return matches;
}

Matches matches_of(const DescriptorKind& kind, const Side& a, const Side& b, double max_ratio) {
  return match_descriptors(kind, {a.descriptors, a.nodes}, {b.descriptors, b.nodes}, max_ratio);
}

Side random_side(const DescriptorKind& kind, size_t count, int nodes, uint64_t seed) {
  Side side{random_descriptors(kind, count, seed), {}};
  for (size_t i = 0; i < count; ++i)
    side.nodes.push_back(7 * static_cast<int32_t>(random_uniform(seed, 1, i) * nodes));
  return side;
}

TEST(MatchDescriptors, FindsWhatComparingAllPairsFinds) {
  // Of one byte each, many are as far from each other as others.
  for (const DescriptorKind& kind :
       {small_kinds()[0], small_kinds()[1], DescriptorKind{"", 1, DescriptorMetric::kHamming},
        DescriptorKind{"", 1, DescriptorMetric::kEuclidean},
        DescriptorKind{"", 19, DescriptorMetric::kHamming},
        DescriptorKind{"", 64, DescriptorMetric::kEuclidean}}) {
    size_t found = 0;
    for (uint64_t seed = 0; seed < 30; ++seed) {
      const Side a = random_side(kind, 40 + seed, 6, 2 * seed),
                 b = random_side(kind, 70 - seed, 6, 2 * seed + 1);
      for (const double ratio : {0.5, 0.75, 1.0}) {
        const Matches matches = matches_of(kind, a, b, ratio);
        EXPECT_EQ(matches, naive_matches(kind, a, b, ratio));
        found += matches.size();
      }
    }
    EXPECT_GT(found, 100u) << kind.bytes;
  }
}

TEST(MatchDescriptors, OfTwoAsNearNeitherIsMeant) {
  const DescriptorKind kind = {"", 1, DescriptorMetric::kEuclidean};
  EXPECT_EQ(matches_of(kind, {{10}, {0}}, {{12, 8}, {0, 0}}, 1.0), Matches{});
  EXPECT_EQ(matches_of(kind, {{10}, {0}}, {{10, 10}, {0, 0}}, 1.0), Matches{});
  EXPECT_EQ(matches_of(kind, {{10}, {0}}, {{12, 8}, {0, 1}}, 0.1), (Matches{{0, 0}}));   // another node
  EXPECT_EQ(matches_of(kind, {{10, 10}, {0, 0}}, {{12}, {0}}, 0.8), (Matches{{0, 0}}));  // the first
}

TEST(MatchDescriptors, TheRatioIsOfDistancesNotOfTheirSquares) {
  const DescriptorKind kind = {"", 1, DescriptorMetric::kEuclidean};
  EXPECT_EQ(matches_of(kind, {{0}, {0}}, {{7, 10}, {0, 0}}, 0.75), (Matches{{0, 0}}));
  EXPECT_EQ(matches_of(kind, {{0}, {0}}, {{8, 10}, {0, 0}}, 0.75), Matches{});
}

TEST(MatchDescriptors, OfNothingIsNothing) {
  const DescriptorKind kind = small_kinds()[0];
  const Side some = random_side(kind, 5, 2, 1);
  EXPECT_EQ(matches_of(kind, {}, some, 0.8), Matches{});
  EXPECT_EQ(matches_of(kind, some, {}, 0.8), Matches{});
  EXPECT_EQ(matches_of(kind, {}, {}, 0.8), Matches{});
}

}  // namespace
}  // namespace kt::test
