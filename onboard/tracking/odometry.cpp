// Constant velocity in time, a second guess where the first one fits badly, and distrust after a gap.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/tracking/odometry.h"

#include <algorithm>
#include <numbers>
#include <tuple>

namespace kt {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

// The motion before a gap says little about what comes later than this.
constexpr double kLongestPrediction_s = 1.0;

// A pose that is not good may be anywhere near: its edge must not outweigh a good one.
constexpr double kUncertainInformation = 1e-2;

// Steps are limited as if frames came at this rate; after a gap the camera may have gone farther, up to this
// factor.
constexpr double kFrameRate_hz = 30, kLargestStepFactor = 4;

}  // namespace

Odometry::Odometry(const exec::Device& device, const Calibration& calibration, const TrackingConfig& config)
    : config_(config),
      tracker_(device, calibration, config),
      rotation_aligner_(device, calibration),
      reference_(device, calibration, calibration.depth.pinhole().half().pixel_count()) {}

void Odometry::remember(const FrameMaps& maps, const ModelView& model) {
  rotation_aligner_.remember(maps);
  const Pose T_reference_model = reference_.T_odom_reference().inverse() * model.T_odom_camera;
  const bool is_near = T_reference_model.translation().norm() <= config_.reference_distance_m &&
                       rotation_angle(T_reference_model) <= config_.reference_angle_deg * kDegree;
  if (is_near && !reference_.is_empty()) return;
  reference_.take(maps, model);
  exposure_ = {};
}

StampedPose Odometry::track(const FrameMaps& maps, const ModelView* model, int64_t sequence,
                            int64_t timestamp_us) {
  const double dt_s = static_cast<double>(timestamp_us - last_good_.timestamp_us) * 1e-6;
  if (model) {
    result_ = best_of_guesses(maps, *model, dt_s);
    // After a gap, or frames that were doubtful, a fair fit may be a wrong one.
    if (result_.status == TrackingStatus::kGood && is_return(timestamp_us) &&
        result_.inlier_share < config_.return_inlier_share)
      result_.status = TrackingStatus::kUncertain;
  } else {
    result_ = {};
    if (tracker_.measured_share(maps) >= config_.min_measured_share) result_.status = TrackingStatus::kGood;
  }

  StampedPose pose;
  pose.sequence = sequence;
  pose.timestamp_us = timestamp_us;
  pose.from_sequence = model ? last_good_.sequence : sequence;
  pose.status = result_.status;
  pose.T_odom_camera = result_.T_odom_camera;
  if (pose.status == TrackingStatus::kGood) {
    pose.information = result_.information;
    if (model) velocity_ = log_se3(last_good_.T_odom_camera.inverse() * pose.T_odom_camera) / dt_s;
    last_good_ = pose;
    exposure_ = result_.exposure;
  } else if (pose.status == TrackingStatus::kUncertain) {
    pose.information = kUncertainInformation * result_.information;
  } else {
    pose.T_odom_camera = last_good_.T_odom_camera;
    pose.information = Matrix6d::Identity();  // 1 rad and 1 m
  }
  last_was_good_ = pose.status == TrackingStatus::kGood;
  last_interval_us_ = timestamp_us - last_us_;
  last_us_ = timestamp_us;
  return pose;
}

TrackResult Odometry::best_of_guesses(const FrameMaps& maps, const ModelView& model, double dt_s) {
  const double step_factor = std::clamp(dt_s * kFrameRate_hz, 1.0, kLargestStepFactor);
  const Pose& T_odom_last = last_good_.T_odom_camera;
  const Pose T_last_moved = exp_se3(velocity_ * std::min(dt_s, kLongestPrediction_s));
  Pose T_last_turned = T_last_moved;
  T_last_turned.linear() = rotation_aligner_.align(maps, T_last_moved.linear());
  struct Attempt {
    Pose T_last_next;
    const PhotometricReference* reference;
  };
  const Attempt attempts[] = {
      {T_last_turned, &reference_},    // as the images turned
      {T_last_moved, nullptr},         // after a gap the reference may look elsewhere, and mislead
      {Pose::Identity(), &reference_}  // a camera that stopped or turned round
  };
  TrackResult best;
  for (const Attempt& attempt : attempts) {
    const TrackResult result = tracker_.track(maps, model, attempt.reference,
                                              T_odom_last * attempt.T_last_next, exposure_, step_factor);
    if (std::tuple(result.status, -result.inlier_share) < std::tuple(best.status, -best.inlier_share))
      best = result;
    if (best.status == TrackingStatus::kGood && best.inlier_share >= config_.sure_inlier_share) break;
  }
  return best;
}

bool Odometry::is_return(int64_t timestamp_us) const {
  return !last_was_good_ || 2 * (timestamp_us - last_us_) > 5 * last_interval_us_;
}

}  // namespace kt
