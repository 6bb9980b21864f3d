// Which pairs are compared; the proof is the collector's.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/loop_search/loop_search.h"

#include <algorithm>
#include <atomic>
#include <map>

#include "onboard/loops/builtin_vocabulary.h"
#include "shared/core/check.h"
#include "shared/core/parallel.h"

namespace kt {
namespace {

// As in the collector: what the keyframe before looks like says little where the camera turns fast.
constexpr float kLeastReference = 0.05f;

}  // namespace

LoopSearch::LoopSearch(const Calibration& calibration, std::vector<Keyframe> keyframes,
                       const LoopSearchConfig& config, int threads)
    : calibration_(calibration), config_(config), threads_(thread_count(threads)) {
  if (keyframes.empty()) return;
  std::vector<const Keyframe*> all;
  for (const Keyframe& keyframe : keyframes) all.push_back(&keyframe);
  vocabulary_ = &vocabulary_of(all);
  const PinholeParams of_depth = keyframe_camera(calibration);
  for (Keyframe& keyframe : keyframes) {
    if (keyframe.depth.width() != of_depth.width || keyframe.depth.height() != of_depth.height)
      keyframe.depth = {};
  }
  places_.resize(keyframes.size());
  bags_.resize(keyframes.size());
  for_each_in_parallel(static_cast<int64_t>(keyframes.size()), threads_, [&](int64_t i) {
    const auto k = static_cast<size_t>(i);
    ImageWords words = vocabulary_->words_of(keyframes[k].descriptors);
    bags_[k] = std::move(words.bag);
    places_[k] = {std::move(keyframes[k]), std::move(words.nodes)};
  });
}

std::vector<LoopSearch::Candidate> LoopSearch::candidates(std::span<const Pose> T_world_camera,
                                                          std::span<const int> group) const {
  const int count = static_cast<int>(places_.size());
  KeyframeIndex index(vocabulary_->word_count());
  std::vector<double> way(places_.size());  // of the camera so far, metres plus radians
  std::map<Pair, float> chosen;
  for (int to = 0; to < count; ++to) {
    const auto k = static_cast<size_t>(to);
    if (to > 0) {
      way[k] = way[k - 1];
      if (group[k] == group[k - 1]) way[k] += movement(T_world_camera[k - 1].inverse() * T_world_camera[k]);
    }
    const int end = to - config_.newest;
    if (end > 0) {
      const float reference = std::max(kLeastReference, similarity(bags_[k], bags_[k - 1]));
      for (const KeyframeIndex::Match& match : index.search(
               bags_[k], end, static_cast<float>(config_.min_similarity) * reference, config_.similar))
        chosen[{to, match.keyframe}] = match.similarity / reference;
      std::vector<std::pair<double, int>> near;
      for (int from = 0; from < end; ++from) {
        const auto f = static_cast<size_t>(from);
        if (group[f] != group[k]) continue;
        const double apart = movement(T_world_camera[f].inverse() * T_world_camera[k]),
                     drift = config_.drift_per_way * (way[k] - way[f]);
        if (apart < config_.near_movement + drift) near.emplace_back(apart, from);
      }
      const size_t most = std::min(near.size(), static_cast<size_t>(config_.near));
      std::partial_sort(near.begin(), near.begin() + static_cast<ptrdiff_t>(most), near.end());
      for (size_t n = 0; n < most; ++n) chosen.try_emplace({to, near[n].second}, 0.0f);
    }
    index.add(bags_[k]);
  }
  std::vector<Candidate> fresh;
  for (const auto& [pair, similarity] : chosen) {
    if (!compared_.contains(pair)) fresh.push_back({pair, similarity});
  }
  return fresh;
}

std::vector<LoopClosure> LoopSearch::search(std::span<const Pose> T_world_camera, std::span<const int> group,
                                            const LoopProgress& progress) {
  KT_CHECK(T_world_camera.size() == places_.size() && group.size() == places_.size());
  if (places_.empty()) return {};
  const std::vector<Candidate> fresh = candidates(T_world_camera, group);
  std::vector<LoopClosure> loops(fresh.size());
  std::atomic<size_t> next{0};
  // A verifier of its own for each thread: it has memory to work in.
  for_each_in_parallel(threads_, threads_, [&](int64_t thread) {
    LoopVerifier verifier(calibration_, vocabulary_->kind(), config_.verification);
    for (size_t i = next++; i < fresh.size(); i = next++) {
      const auto [to, from] = fresh[i].pair;
      loops[i] = verifier.verify(places_[static_cast<size_t>(from)], places_[static_cast<size_t>(to)]);
      loops[i].similarity = fresh[i].similarity;
      loops[i].sequence = sequence_ + static_cast<int64_t>(i);
      if (progress && thread == 0) progress(static_cast<double>(i + 1) / static_cast<double>(fresh.size()));
    }
  });
  sequence_ += static_cast<int64_t>(loops.size());
  for (const Candidate& candidate : fresh) compared_.insert(candidate.pair);
  return loops;
}

}  // namespace kt
