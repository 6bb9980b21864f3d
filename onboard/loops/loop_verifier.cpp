// The tests of a loop candidate, in order.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/loops/loop_verifier.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "onboard/loops/descriptor_matcher.h"
#include "onboard/preprocess/frame_motion.h"
#include "shared/core/rng.h"

namespace kt {
namespace {

constexpr int kMostDraws = 500, kFewestDraws = 30;
constexpr double kRansacFailure = 1e-4;
constexpr double kLeastTriangle_m2 = 2e-3;  // smaller ones say little of the rotation

// A motion known less well than this is not known.
constexpr double kMaxRotationSigma = 0.01, kMaxTranslationSigma = 0.015;  // rad, m

// The two costs count pixels and features that err together as fewer; what they say of the closure that they
// agree on is still too little (docs/loops.md).
constexpr double kInformationGain = 4;

// Of the inliers of the features, so many must still be some where the surfaces put the camera.
constexpr double kLeastKeptInliers = 0.6;

// Normals of a distant surface are noisy: of two views of one place every fifth differs.
constexpr double kMostTurned = 0.4;

// Size of the structure, in pixels of the intensity image, that a corner of level 0 has.
constexpr double kScaleOfFinest_px = 1.5;

/// Features in the intensity image, at half the resolution of the colour image.
std::vector<Feature> features_of(const Keyframe& keyframe) {
  std::vector<Feature> features(keyframe.u_px.size());
  for (size_t i = 0; i < features.size(); ++i) {
    Feature& feature = features[i];
    feature.pixel = {(static_cast<double>(keyframe.u_px[i]) + 0.5) / 2 - 0.5,
                     (static_cast<double>(keyframe.v_px[i]) + 0.5) / 2 - 0.5};
    feature.p_camera = to_eigen(keyframe.p_camera[i]);
    double scale = static_cast<double>(keyframe.scale_px[i]) / 2 / kScaleOfFinest_px;
    for (feature.level = 0; scale > 1.42 && feature.level < 5; scale /= 2) ++feature.level;
  }
  return features;
}

struct Consensus {
  Pose T_from_to = Pose::Identity();
  std::vector<FeatureMatch> inliers;
};

/// The motion by three matches that most matches agree with (Fischler and Bolles 1981); what is drawn depends
/// on the two frames alone.
Consensus find_consensus(std::span<const Feature> from, std::span<const Feature> to,
                         std::span<const FeatureMatch> matches, const FeatureCamera& camera, uint64_t seed,
                         uint64_t stream) {
  Consensus best;
  const auto count = static_cast<double>(matches.size());
  int draws = kMostDraws;
  std::vector<FeatureMatch> inliers;
  for (int draw = 0; draw < draws; ++draw) {
    std::array<FeatureMatch, 3> sample;
    std::array<size_t, 3> picks{};
    for (size_t k = 0; k < 3; ++k) {
      const double share = random_uniform(seed, stream, 3 * static_cast<uint64_t>(draw) + k);
      picks[k] = std::min(static_cast<size_t>(share * count), matches.size() - 1);
      sample[k] = matches[picks[k]];
    }
    if (picks[0] == picks[1] || picks[0] == picks[2] || picks[1] == picks[2]) continue;
    const auto triangle = [&sample](std::span<const Feature> features, int FeatureMatch::*side) {
      const auto p = [&](size_t k) { return features[static_cast<size_t>(sample[k].*side)].p_camera; };
      return (p(1) - p(0)).cross(p(2) - p(0)).norm();
    };
    const double area_from = triangle(from, &FeatureMatch::a), area_to = triangle(to, &FeatureMatch::b);
    if (std::min(area_from, area_to) < kLeastTriangle_m2 ||
        std::max(area_from, area_to) > 2 * std::min(area_from, area_to))
      continue;
    const Pose T = absolute_orientation(from, to, sample, camera);
    inliers.clear();
    for (const FeatureMatch& match : matches) {
      if (is_explained(from[static_cast<size_t>(match.a)], to[static_cast<size_t>(match.b)], T, camera))
        inliers.push_back(match);
    }
    if (inliers.size() <= best.inliers.size()) continue;
    best = {T, inliers};
    const double share = static_cast<double>(inliers.size()) / count;
    const double enough = std::log(kRansacFailure) / std::log(std::max(1e-9, 1 - share * share * share));
    draws = std::clamp(static_cast<int>(enough) + 1, kFewestDraws, kMostDraws);
  }
  return best;
}

}  // namespace

LoopVerifier::LoopVerifier(const Calibration& calibration, const DescriptorKind& kind,
                           const VerificationConfig& config)
    : config_(config),
      kind_(kind),
      camera_{calibration.colour.pinhole().half(), calibration.T_colour_depth},
      depth_camera_(keyframe_camera(calibration)),
      readout_s_(calibration.readout_s),
      cpu_(exec::Device::cpu(1)),
      surfaces_(depth_camera_) {}

LoopClosure LoopVerifier::verify(const Place& place_from, const Place& place_to) {
  const Keyframe &from = place_from.keyframe, &to = place_to.keyframe;
  LoopClosure loop;
  loop.timestamp_us = to.timestamp_us;
  loop.from = from.sequence;
  loop.to = to.sequence;
  const auto reject = [&loop](LoopVerdict verdict) {
    loop.verdict = verdict;
    return loop;
  };

  std::vector<FeatureMatch> matches =
      match_descriptors(kind_, {from.descriptors, place_from.nodes}, {to.descriptors, place_to.nodes},
                        config_.max_descriptor_ratio);
  std::erase_if(matches, [&](const FeatureMatch& match) {
    return from.p_camera[static_cast<size_t>(match.a)].z <= 0 ||
           to.p_camera[static_cast<size_t>(match.b)].z <= 0;
  });
  loop.matches = static_cast<int>(matches.size());
  if (loop.matches < config_.min_matches) return reject(LoopVerdict::kTooFewMatches);

  const std::vector<Feature> features_from = features_of(from), features_to = features_of(to);
  const Consensus consensus =
      find_consensus(features_from, features_to, matches, camera_, static_cast<uint64_t>(from.sequence),
                     static_cast<uint64_t>(to.sequence));
  const auto enough =
      std::max(config_.min_inliers, static_cast<int>(std::ceil(config_.min_inlier_share * loop.matches)));
  if (static_cast<int>(consensus.inliers.size()) < enough) return reject(LoopVerdict::kTooFewInliers);

  const FeatureAlignment refined = refine_alignment(features_from, features_to, matches, consensus.T_from_to,
                                                    consensus.inliers, camera_, config_.min_inliers);
  loop.reprojection_px = static_cast<float>(refined.rms_px);
  if (refined.status == FeatureStatus::kTooFewInliers) return reject(LoopVerdict::kTooFewInliers);
  if (refined.status == FeatureStatus::kReprojectionError) return reject(LoopVerdict::kReprojection);
  if (refined.status != FeatureStatus::kOk) return reject(LoopVerdict::kUnconstrained);

  const auto surface_of = [this](const Keyframe& keyframe) {
    return KeptPlaceSurface(cpu_, keyframe.depth, depth_camera_,
                            row_motion(keyframe.velocity, readout_s_, depth_camera_));
  };
  const KeptPlaceSurface surface_from = surface_of(from), surface_to = surface_of(to);
  const auto feature_terms = [&](const Pose& T, Matrix6d* A, Vector6d* b) {
    const FeatureEquations sums =
        feature_equations(features_from, features_to, refined.inlier_matches, T, camera_);
    const double trust = sums.trust(refined.inlier_matches.size());
    *A += trust * sums.A;
    *b += trust * sums.b;
  };
  const SurfaceAlignment aligned = surfaces_.align(surface_from, surface_to, refined.T_a_b, feature_terms);
  loop.T_from_to = aligned.T_from_to;
  loop.information = aligned.information;
  Vector6d gradient = Vector6d::Zero();
  feature_terms(loop.T_from_to, &loop.information, &gradient);
  loop.information *= kInformationGain;
  int kept = 0;
  for (const FeatureMatch& match : refined.inlier_matches) {
    const auto a = static_cast<size_t>(match.a), b = static_cast<size_t>(match.b);
    kept += is_explained(features_from[a], features_to[b], loop.T_from_to, camera_);
    loop.p_from.push_back(from.p_camera[a]);
    loop.p_to.push_back(to.p_camera[b]);
  }
  const SurfaceAgreement there = SurfaceAligner::agreement(surface_from, surface_to, loop.T_from_to),
                         back = SurfaceAligner::agreement(surface_to, surface_from, loop.T_from_to.inverse());
  const double square_m2 = (there.squares_m2 + back.squares_m2) /
                           static_cast<double>(std::max<int64_t>(1, there.same + back.same));
  loop.overlap = static_cast<float>(std::min(there.overlap(), back.overlap()));
  loop.surface_rms_m = static_cast<float>(std::sqrt(square_m2));
  if (static_cast<double>(loop.overlap) < config_.min_overlap) return reject(LoopVerdict::kLittleOverlap);
  if (square_m2 > config_.max_surface_error_m2 ||
      std::max(there.conflict(), back.conflict()) > config_.max_conflict ||
      std::max(there.turned_share(), back.turned_share()) > kMostTurned ||
      kept < kLeastKeptInliers * static_cast<double>(refined.inlier_matches.size()))
    return reject(LoopVerdict::kSurfaceMismatch);
  if (!is_constrained(loop.information, kMaxRotationSigma, kMaxTranslationSigma))
    return reject(LoopVerdict::kUnconstrained);
  loop.verdict = LoopVerdict::kAccepted;
  return loop;
}

}  // namespace kt
