// Matches pair by pair, then joins what is matched.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/refinement/feature_tracks.h"

#include <algorithm>
#include <map>
#include <numeric>

#include "onboard/loops/builtin_vocabulary.h"
#include "onboard/loops/descriptor_matcher.h"
#include "onboard/preprocess/depth_map.h"
#include "shared/core/parallel.h"

namespace kt {
namespace {

constexpr double kMaxDescriptorRatio = 0.8;
// How far a match may lie from where the poses put it: what they err by, and false ones are far outside.
constexpr double kMaxApart_px = 8, kMaxApart_m = 0.04, kMaxApartSigmas = 4;
// Features are found to a share of the size of their structure, but no better than this (px).
constexpr double kSigmaOfScale = 0.12, kFinestSigma_px = 0.5;

using FeatureId = std::pair<int, int>;  // keyframe, feature

Observation observation_of(const Keyframe& keyframe, FeatureId id) {
  const auto i = static_cast<size_t>(id.second);
  Observation seen;
  seen.keyframe = id.first;
  seen.pixel = {static_cast<double>(keyframe.u_px[i]), static_cast<double>(keyframe.v_px[i])};
  seen.p_camera = to_eigen(keyframe.p_camera[i]);
  seen.sigma_px = std::max(kFinestSigma_px, kSigmaOfScale * static_cast<double>(keyframe.scale_px[i]));
  seen.sigma_z = static_cast<double>(depth_sigma_m(keyframe.p_camera[i].z));
  return seen;
}

// Whether `b`, moved to the camera of `a`, falls on it.
bool is_near(const Observation& a, const Observation& b, const Pose& T_a_b, const Calibration& calibration) {
  const Eigen::Vector3d p = T_a_b * b.p_camera;
  const double across = kMaxApartSigmas * std::hypot(a.sigma_z, b.sigma_z) + kMaxApart_m;
  if (p.z() <= 0 || std::abs(p.z() - a.p_camera.z()) > across) return false;
  const Eigen::Vector3d c = calibration.T_colour_depth * p;
  const Camera& camera = calibration.colour;
  const Eigen::Vector2d pixel(camera.fx * c.x() / c.z() + camera.cx, camera.fy * c.y() / c.z() + camera.cy);
  return (pixel - a.pixel).norm() < kMaxApart_px;
}

// Sets of features, as a forest: each points to its set's first.
class FeatureSets {
 public:
  explicit FeatureSets(std::span<const Keyframe* const> keyframes) {
    for (const Keyframe* keyframe : keyframes) {
      first_.push_back(count_);
      count_ += keyframe->u_px.size();
    }
    parent_.resize(count_);
    std::iota(parent_.begin(), parent_.end(), size_t{0});
    members_.resize(count_);
  }

  // Unless a keyframe would be in the set twice: one of its two features is another point then.
  void join(FeatureId a, FeatureId b) {
    size_t of_a = find(a), of_b = find(b);
    if (of_a == of_b) return;
    std::vector<FeatureId> both, &in_a = members(of_a, a), &in_b = members(of_b, b);
    std::merge(in_a.begin(), in_a.end(), in_b.begin(), in_b.end(), std::back_inserter(both));
    const auto same_keyframe = [](FeatureId x, FeatureId y) { return x.first == y.first; };
    if (std::adjacent_find(both.begin(), both.end(), same_keyframe) != both.end()) return;
    if (of_b < of_a) std::swap(of_a, of_b);
    parent_[of_b] = of_a;
    members_[of_b].clear();
    members_[of_a] = std::move(both);
  }

  std::vector<std::vector<FeatureId>> sets() const {
    std::vector<std::vector<FeatureId>> result;
    for (const std::vector<FeatureId>& set : members_) {
      if (set.size() > 1) result.push_back(set);
    }
    return result;
  }

 private:
  size_t find(FeatureId id) {
    size_t at = first_[static_cast<size_t>(id.first)] + static_cast<size_t>(id.second);
    while (parent_[at] != at) at = parent_[at] = parent_[parent_[at]];
    return at;
  }
  std::vector<FeatureId>& members(size_t set, FeatureId id) {
    if (members_[set].empty()) members_[set] = {id};
    return members_[set];
  }

  size_t count_ = 0;
  std::vector<size_t> first_, parent_;
  std::vector<std::vector<FeatureId>> members_;  // of sets of several
};

}  // namespace

std::vector<FeatureTrack> find_tracks(const Calibration& calibration,
                                      std::span<const Keyframe* const> keyframes,
                                      std::span<const Pose> T_world_camera,
                                      std::span<const KeyframePair> pairs, int threads) {
  if (keyframes.empty()) return {};
  const Vocabulary& vocabulary = vocabulary_of(keyframes);
  std::vector<std::vector<int32_t>> nodes(keyframes.size());
  for_each_in_parallel(static_cast<int64_t>(keyframes.size()), threads, [&](int64_t k) {
    nodes[static_cast<size_t>(k)] = vocabulary.words_of(keyframes[static_cast<size_t>(k)]->descriptors).nodes;
  });
  std::vector<std::vector<FeatureMatch>> matches(pairs.size());
  for_each_in_parallel(static_cast<int64_t>(pairs.size()), threads, [&](int64_t i) {
    const auto [a, b] = pairs[static_cast<size_t>(i)];
    const auto of_a = static_cast<size_t>(a), of_b = static_cast<size_t>(b);
    const Pose T_a_b = T_world_camera[of_a].inverse(Eigen::Isometry) * T_world_camera[of_b];
    const Keyframe &from = *keyframes[of_a], &to = *keyframes[of_b];
    std::vector<FeatureMatch>& found = matches[static_cast<size_t>(i)];
    found = match_descriptors(vocabulary.kind(), {from.descriptors, nodes[of_a]},
                              {to.descriptors, nodes[of_b]}, kMaxDescriptorRatio);
    std::erase_if(found, [&](const FeatureMatch& match) {
      const Observation in_a = observation_of(from, {a, match.a}), in_b = observation_of(to, {b, match.b});
      return in_a.p_camera.z() <= 0 || in_b.p_camera.z() <= 0 || !is_near(in_a, in_b, T_a_b, calibration) ||
             !is_near(in_b, in_a, T_a_b.inverse(Eigen::Isometry), calibration);
    });
  });
  FeatureSets sets(keyframes);
  for (size_t i = 0; i < pairs.size(); ++i) {
    for (const FeatureMatch& match : matches[i])
      sets.join({pairs[i].first, match.a}, {pairs[i].second, match.b});
  }
  std::vector<FeatureTrack> tracks;
  for (const std::vector<FeatureId>& set : sets.sets()) {
    FeatureTrack& track = tracks.emplace_back();
    for (const FeatureId& id : set)
      track.push_back(observation_of(*keyframes[static_cast<size_t>(id.first)], id));
  }
  return tracks;
}

}  // namespace kt
