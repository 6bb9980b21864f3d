// Features of one frame against those of keyframes.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/tracking/keyframe_tracker.h"

#include <limits>

namespace kt {
namespace {

// A keyframe farther from the guess, by the paper's metric, shares too little of the view.
constexpr double kNear = 1.0;

// The odometry has drifted since an older one: it says where the camera is in the room, not in the model.
constexpr int64_t kRecent_us = 20'000'000;

}  // namespace

KeyframeTracker::KeyframeTracker(const exec::Device& device, const Calibration& calibration,
                                 const TrackingConfig& config)
    : config_(config),
      camera_{calibration.colour.pinhole().half(), calibration.T_colour_depth},
      detector_(device, calibration),
      surfaces_(device, calibration, int64_t{config.max_keyframes} + 1),  // a new one comes before one goes
      store_(config.max_keyframes) {}

void KeyframeTracker::look_at(const FrameMaps& maps, const FrameMotion& motion) {
  maps_ = &maps;
  motion_ = motion;
  features_.reset();
}

const std::vector<Feature>& KeyframeTracker::features() {
  if (!features_) features_ = detector_.detect(*maps_, motion_);
  return *features_;
}

std::optional<KeyframeTracker::Found> KeyframeTracker::find_near(int segment, const Pose& T_odom_guess) {
  const auto nearest = store_.nearest(segment, T_odom_guess, maps_->timestamp_us - kRecent_us);
  if (!nearest || nearest->distance > kNear) return std::nullopt;
  return find_at(nearest->index);
}

KeyframeTracker::Found KeyframeTracker::find_at(int keyframe) {
  const StoredKeyframe& stored = store_.at(keyframe);
  const FeatureAlignment alignment =
      align_features(stored.features, features(), camera_, config_.min_feature_inliers);
  return {keyframe, alignment, stored.T_odom_camera * alignment.T_a_b};
}

std::optional<int> KeyframeTracker::nearest(int segment, const Pose& T_odom_camera) const {
  const auto found = store_.nearest(segment, T_odom_camera, std::numeric_limits<int64_t>::min());
  return found ? std::optional(found->index) : std::nullopt;
}

void KeyframeTracker::remember(int64_t sequence, int segment, const Pose& T_odom_camera,
                               const FrameMotion& motion) {
  const auto nearest = store_.nearest(segment, T_odom_camera, maps_->timestamp_us - kRecent_us);
  if (nearest && nearest->distance < config_.keyframe_distance) return;
  store_.add(
      {sequence, maps_->timestamp_us, segment, T_odom_camera, features(), surfaces_.keep(*maps_, motion)});
}

}  // namespace kt
