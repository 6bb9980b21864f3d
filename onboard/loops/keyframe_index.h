// An inverted file of the words that keyframes show.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "onboard/loops/vocabulary.h"

namespace kt {

class KeyframeIndex {
 public:
  explicit KeyframeIndex(int words) : postings_(static_cast<size_t>(words)) {}

  /// Adds the next keyframe; they are numbered from 0.
  void add(const BagOfWords& bag);
  int size() const { return size_; }

  struct Match {
    int keyframe = 0;
    float similarity = 0;
  };
  /// Places that look like `bag`, most similar first, at most `count`, among the first `end` keyframes: of
  /// keyframes not less than `least_similarity` like it, those that follow each other closely are one place,
  /// as similar as all of them together, and its most similar keyframe stands for it (the islands of
  /// Galvez-Lopez and Tardos 2012).
  std::vector<Match> search(const BagOfWords& bag, int end, float least_similarity, int count) const;

 private:
  struct Posting {
    int32_t keyframe;
    float weight;
  };
  std::vector<std::vector<Posting>> postings_;  // by word
  int size_ = 0;
};

}  // namespace kt
