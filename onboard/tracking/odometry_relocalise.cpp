// How a lost camera is found at a keyframe again, and how the next frame confirms it.
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <utility>

#include "onboard/tracking/odometry.h"
#include "onboard/tracking/step_limit.h"

namespace kt {
namespace {

// A camera that is found again shows so much of the keyframe, and is confirmed within this time.
constexpr double kLeastKeyframeOverlap = 0.3, kLongestConfirmation_s = 0.5;

}  // namespace

std::optional<Odometry::Estimate> Odometry::relocalise(const FrameMaps& maps, const PredictSurface& predict,
                                                       const FindPlace& find_place) {
  const auto place = find_place ? find_place(maps) : std::nullopt;
  if (!place) return std::nullopt;
  const auto keyframe = keyframes_.nearest(place->segment, place->T_odom_camera);
  if (!keyframe) return std::nullopt;
  Estimate estimate = by_keyframe(maps, predict, *keyframe, place->T_odom_camera);
  if (estimate.result.status != TrackingStatus::kGood) return std::nullopt;
  candidate_ = Candidate{estimate.result.T_odom_camera, maps.timestamp_us, *keyframe};
  estimate.result.status = TrackingStatus::kUncertain;
  estimate.result.cause = TrackingCause::kUnconfirmed;
  return estimate;
}

std::optional<Odometry::Estimate> Odometry::confirm(const FrameMaps& maps, const PredictSurface& predict) {
  if (!candidate_) return std::nullopt;
  const Candidate candidate = *std::exchange(candidate_, std::nullopt);
  const double dt_s = seconds(candidate.timestamp_us, maps.timestamp_us);
  if (dt_s > std::max(kLongestConfirmation_s, 2e-6 * static_cast<double>(last_interval_us_)))
    return std::nullopt;
  const auto found = keyframes_.find_at(candidate.keyframe);
  const Pose& T_guess =
      found.alignment.status == FeatureStatus::kOk ? found.T_odom_camera : candidate.T_odom_camera;
  const Estimate estimate = by_keyframe(maps, predict, candidate.keyframe, T_guess);
  const Pose T_step = candidate.T_odom_camera.inverse() * estimate.result.T_odom_camera;
  if (estimate.result.status != TrackingStatus::kGood || !is_possible_step(T_step, dt_s, config_))
    return std::nullopt;
  return estimate;
}

Odometry::Estimate Odometry::by_keyframe(const FrameMaps& maps, const PredictSurface& predict, int index,
                                         const Pose& T_odom_guess) {
  const StoredKeyframe& keyframe = keyframes_.keyframe(index);
  Estimate estimate;
  estimate.source = PoseSource::kRelocalised;
  estimate.segment = keyframe.segment;
  estimate.from_sequence = keyframe.sequence;
  const auto align = [&](const ModelView& view, const Pose& T_guess) {
    const TrackResult result = tracker_.track(maps, view, nullptr, {T_guess});
    const bool is_fit =
        result.status == TrackingStatus::kGood && result.quality.inlier_share >= config_.return_inlier_share;
    return std::pair(result, is_fit);
  };
  const auto [seen, is_fit] = align(views_.view(keyframe.surface, keyframe.T_odom_camera), T_odom_guess);
  estimate.result = seen;
  estimate.information = seen.information;
  if (!is_fit || seen.quality.overlap < kLeastKeyframeOverlap || seen.quality.free_directions > 0) {
    estimate.result.status = TrackingStatus::kLost;
    return estimate;
  }
  if (keyframe.segment != last_good_.segment) return estimate;
  // Where the volume still holds the place, its surface decides.
  const ModelView& model = predict(seen.T_odom_camera);
  const auto [result, is_model_fit] = align(model, seen.T_odom_camera);
  if (result.quality.overlap < kLeastKeyframeOverlap) return estimate;
  estimate.result = result;
  estimate.information =
      transported(result.information, model.T_odom_camera.inverse() * keyframe.T_odom_camera);
  if (!is_model_fit) estimate.result.status = TrackingStatus::kLost;
  return estimate;
}

}  // namespace kt
