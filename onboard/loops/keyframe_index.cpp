// Search by words.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/loops/keyframe_index.h"

#include <algorithm>

namespace kt {
namespace {

constexpr int kIslandGap = 3;  // keyframes: nearer ones show one place

}  // namespace

void KeyframeIndex::add(const BagOfWords& bag) {
  for (const auto& [word, weight] : bag.entries) postings_.at(size_t(word)).push_back({size_, weight});
  ++size_;
}

std::vector<KeyframeIndex::Match> KeyframeIndex::search(const BagOfWords& bag, int end,
                                                        float least_similarity, int count) const {
  std::vector<float> similarities(static_cast<size_t>(std::clamp(end, 0, size_)));
  for (const auto& [word, weight] : bag.entries) {
    for (const Posting& posting : postings_.at(size_t(word))) {
      if (posting.keyframe >= end) break;
      similarities[size_t(posting.keyframe)] += std::min(weight, posting.weight);
    }
  }
  struct Island {
    Match best;
    float sum = 0;
    int last = 0;
  };
  std::vector<Island> islands;
  for (int keyframe = 0; keyframe < static_cast<int>(similarities.size()); ++keyframe) {
    const float similarity = similarities[size_t(keyframe)];
    if (similarity <= 0 || similarity < least_similarity) continue;
    if (islands.empty() || keyframe - islands.back().last > kIslandGap) islands.push_back({});
    Island& island = islands.back();
    if (similarity > island.best.similarity) island.best = {keyframe, similarity};
    island.sum += similarity;
    island.last = keyframe;
  }
  std::stable_sort(islands.begin(), islands.end(),
                   [](const Island& a, const Island& b) { return a.sum > b.sum; });
  std::vector<Match> matches;
  for (const Island& island : islands) {
    if (static_cast<int>(matches.size()) == count) break;
    matches.push_back(island.best);
  }
  return matches;
}

}  // namespace kt
