// Tests of the search for keyframes by words.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/loops/keyframe_index.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <numeric>

#include "gtest/gtest.h"

#include "shared/core/rng.h"

namespace kt::test {
namespace {

constexpr int kAll = 1 << 20;

// `count` different words of `words`.
BagOfWords random_bag(int words, int count, uint64_t seed) {
  std::vector<int32_t> drawn(static_cast<size_t>(words));
  std::iota(drawn.begin(), drawn.end(), 0);
  BagOfWords bag;
  float sum = 0;
  for (size_t i = 0; i < static_cast<size_t>(count); ++i) {
    const double share = random_uniform(seed, 0, i);
    std::swap(drawn[i], drawn[i + static_cast<size_t>(share * static_cast<double>(drawn.size() - i))]);
    bag.entries.push_back({drawn[i], 0.1f + static_cast<float>(random_uniform(seed, 1, i))});
    sum += bag.entries.back().weight;
  }
  for (BagOfWords::Entry& entry : bag.entries) entry.weight /= sum;
  std::sort(bag.entries.begin(), bag.entries.end(), [](auto& a, auto& b) { return a.word < b.word; });
  return bag;
}

// Keyframe k shares `shares[k]` with the bag of word 0 alone.
KeyframeIndex index_of(const std::vector<float>& shares) {
  KeyframeIndex index(2);
  for (const float share : shares) {
    BagOfWords bag;
    if (share > 0) bag.entries.push_back({0, share});
    if (share < 1) bag.entries.push_back({1, 1 - share});
    index.add(bag);
  }
  return index;
}
const BagOfWords kWord0{{{0, 1.0f}}};

std::vector<int> keyframes_of(const std::vector<KeyframeIndex::Match>& matches) {
  std::vector<int> keyframes;
  for (const KeyframeIndex::Match& match : matches) keyframes.push_back(match.keyframe);
  return keyframes;
}

TEST(KeyframeIndex, FindsWhatComparingWithEachKeyframeFinds) {
  constexpr int kWords = 40, kGap = 4, kKeyframes = 60;
  KeyframeIndex index(kWords);
  std::vector<BagOfWords> bags;
  for (int k = 0; k < kKeyframes; ++k) {  // so far apart that each is a place of its own
    bags.push_back(random_bag(kWords, 1 + k % 7, static_cast<uint64_t>(k)));
    index.add(bags.back());
    for (int i = 1; i < kGap; ++i) index.add({});
  }
  EXPECT_EQ(index.size(), kKeyframes * kGap);
  for (uint64_t seed = 100; seed < 120; ++seed) {
    const BagOfWords bag = random_bag(kWords, 6, seed);
    for (const int end : {0, 1, 90, 93, kKeyframes * kGap, kAll}) {
      std::vector<std::pair<float, int>> expected;
      for (int k = 0; k < kKeyframes && k * kGap < end; ++k) {
        const float like = similarity(bag, bags[static_cast<size_t>(k)]);
        if (like > 0 && like >= 0.05f) expected.emplace_back(-like, k * kGap);
      }
      std::sort(expected.begin(), expected.end());
      const auto found = index.search(bag, end, 0.05f, kAll);
      ASSERT_EQ(found.size(), expected.size()) << end;
      for (size_t i = 0; i < found.size(); ++i) {
        EXPECT_EQ(found[i].similarity, -expected[i].first);
        EXPECT_EQ(found[i].keyframe, expected[i].second);
      }
    }
  }
}

TEST(KeyframeIndex, LooksAtTheFirstKeyframesOnly) {
  const KeyframeIndex index = index_of({0.2f, 0, 0, 0, 0, 0, 0.9f});
  EXPECT_EQ(keyframes_of(index.search(kWord0, 7, 0, kAll)), (std::vector<int>{6, 0}));
  EXPECT_EQ(keyframes_of(index.search(kWord0, 6, 0, kAll)), (std::vector<int>{0}));
  EXPECT_TRUE(index.search(kWord0, 0, 0, kAll).empty());
  EXPECT_TRUE(index.search(kWord0, -5, 0, kAll).empty());
  EXPECT_TRUE(index.search({}, 7, 0, kAll).empty());
  EXPECT_TRUE(KeyframeIndex(2).search(kWord0, 7, 0, kAll).empty());
}

TEST(KeyframeIndex, KeyframesThatFollowEachOtherAreOnePlace) {
  // Two keyframes in between do not separate, three do.
  const KeyframeIndex index = index_of({0.3f, 0.4f, 0, 0, 0.25f, 0, 0, 0, 0.8f, 0, 0, 0, 0.1f});
  const auto found = index.search(kWord0, kAll, 0, kAll);
  ASSERT_EQ(keyframes_of(found), (std::vector<int>{1, 8, 12}));  // 0.95 together, 0.8, 0.1
  EXPECT_EQ(found[0].similarity, 0.4f);
  EXPECT_EQ(keyframes_of(index.search(kWord0, kAll, 0, 2)), (std::vector<int>{1, 8}));
  EXPECT_TRUE(index.search(kWord0, kAll, 0, 0).empty());
  // Those less alike than asked for add nothing.
  EXPECT_EQ(keyframes_of(index.search(kWord0, kAll, 0.35f, kAll)), (std::vector<int>{8, 1}));
}

TEST(KeyframeIndex, OfEqualOnesTheFirstIsNamed) {
  EXPECT_EQ(keyframes_of(index_of({0.5f, 0.5f, 0, 0, 0, 0, 0.5f, 0.5f}).search(kWord0, kAll, 0, kAll)),
            (std::vector<int>{0, 6}));
}

TEST(KeyframeIndex, AnswersForTenThousandKeyframes) {
  constexpr int kWords = 10'000, kKeyframes = 10'000, kEach = 200, kQueries = 21;
  KeyframeIndex index(kWords);
  for (int k = 0; k < kKeyframes; ++k) {
    BagOfWords bag;  // a word of every stretch of the vocabulary: quickly drawn
    for (int i = 0; i < kEach; ++i) {
      const double share = random_uniform(static_cast<uint64_t>(k), 2, static_cast<uint64_t>(i));
      bag.entries.push_back(
          {i * (kWords / kEach) + static_cast<int32_t>(share * (kWords / kEach)), 1.0f / kEach});
    }
    index.add(bag);
  }
  std::vector<double> times_ms;
  for (uint64_t query = 0; query < kQueries; ++query) {
    const BagOfWords bag = random_bag(kWords, kEach, query);
    const auto start = std::chrono::steady_clock::now();
    const auto found = index.search(bag, kKeyframes, 0.01f, 3);
    times_ms.push_back(
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count());
    EXPECT_EQ(found.size(), 3u);
  }
  std::nth_element(times_ms.begin(), times_ms.begin() + kQueries / 2, times_ms.end());
  std::printf("median query among %d keyframes of %d words: %.3f ms\n", kKeyframes, kEach,
              times_ms[kQueries / 2]);
}

}  // namespace
}  // namespace kt::test
