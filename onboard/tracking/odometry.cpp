// The order of what is tried for a frame, and what is believed of it.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/tracking/odometry.h"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "onboard/tracking/edge_information.h"
#include "onboard/tracking/step_limit.h"

namespace kt {
namespace {

// After a longer time an edge or a blob may have gone by more than the alignment reaches: a wall that slides
// along itself fits none the less.
constexpr double kReach_s = 0.08;

// The motion before a gap says little about what comes later than this.
constexpr double kLongestPrediction_s = 1.0;

// The last good frame shares enough of the view for so long.
constexpr double kLongestPairwise_s = 0.3;

// A pose that is not good may be anywhere near: its edge must not outweigh a good one.
constexpr double kUncertainInformation = 1e-2;

// A view predicted from a pose as near as this serves for the frame.
constexpr double kSameView_m = 0.15, kSameView_rad = 10 * kDegree;

// Poses of one frame found by different means agree within this.
constexpr double kAgreement_m = 0.04, kAgreement_rad = 2 * kDegree;

// Of the last good frame's inlier share.
constexpr double kReturnShare = 0.9;

// What covers a lens is nearer, and blurred.
constexpr double kNotAHand_m = 0.6;
constexpr int kFeaturesOfAPlace = 30;

// Of the time between two frames, this much counts as search: a gap is none.
constexpr int64_t kLongestSearch_us = 200'000;

}  // namespace

Odometry::Odometry(const exec::Device& device, const Calibration& calibration, const TrackingConfig& config)
    : config_(config),
      T_odom_start_(calibration.T_body_camera),
      tracker_(device, calibration, config),
      rotation_aligner_(device, calibration),
      reference_(device, calibration, calibration.depth.pinhole().half().pixel_count()),
      keyframes_(device, calibration, config),
      views_(device, calibration),
      last_surfaces_(device, calibration, 2) {  // one is kept while the one before it is there
  last_good_.T_odom_camera = T_odom_start_;
}

void Odometry::remember(const FrameMaps& maps, const ModelView* model) {
  rotation_aligner_.remember(maps);
  const FrameMotion motion(maps, steady_velocity_);
  last_surface_ = last_surfaces_.keep(maps, motion);
  keyframes_.remember(last_good_.sequence, last_good_.segment, last_good_.T_odom_camera, motion);
  if (!model) return;  // the image reference needs surface seen from where the frame is
  const Pose T_reference_model = reference_.T_odom_reference().inverse() * model->T_odom_camera;
  const bool is_near =
      is_within(T_reference_model, config_.reference_distance_m, config_.reference_angle_deg * kDegree);
  if (is_near && !reference_.is_empty()) return;
  reference_.take(maps, *model, motion);
  exposure_ = {};
}

StampedPose Odometry::track(const FrameMaps& maps, const ModelView* model, const PredictSurface& predict,
                            const FindPlace& find_place, int64_t sequence) {
  keyframes_.look_at(maps, FrameMotion(maps, steady_velocity_));
  tried_fallbacks_ = false;
  if (!model) return start_segment(maps, sequence);
  motion_ = motion_prior_.between(last_good_.timestamp_us, maps.timestamp_us);
  Estimate estimate;
  tried_fallbacks_ = candidate_.has_value();
  if (const auto confirmed = confirm(maps, predict)) {
    estimate = *confirmed;
  } else {
    estimate = follow(maps, *model, predict);
    doubt(maps, estimate);
    const bool is_search = estimate.result.status != TrackingStatus::kGood && frames_since_good_ > 0;
    if (is_search) {
      if (const auto found = relocalise(maps, predict, find_place)) estimate = *found;
    }
    if (estimate.result.status == TrackingStatus::kLost && is_carried()) estimate = dead_reckoned(estimate);
  }
  if (estimate.result.status != TrackingStatus::kGood && shows_a_place(maps)) {
    usable_lost_us_ += std::min(maps.timestamp_us - last_us_, kLongestSearch_us);
    // One that was found just now has a frame more to be confirmed.
    const int64_t patience_us = candidate_ ? kLongestSearch_us : 0;
    if (static_cast<double>(usable_lost_us_ - patience_us) * 1e-6 >= config_.new_segment_after_s)
      return start_segment(maps, sequence);
  }
  return conclude(maps, estimate, sequence);
}

Odometry::Estimate Odometry::follow(const FrameMaps& maps, const ModelView& model,
                                    const PredictSurface& predict) {
  const Pose& T_odom_last = last_good_.T_odom_camera;
  const double dt_s = seconds(last_good_.timestamp_us, maps.timestamp_us);
  const auto guess_at = [&](const Pose& T_odom_camera) {
    TrackGuess guess{T_odom_camera, exposure_};
    guess.approach = {T_odom_last, velocity_, dt_s};
    if (motion_) {
      guess.T_odom_motion = T_odom_last * sensed_motion(T_odom_last.inverse() * T_odom_camera);
      guess.motion_information = transported(motion_->information, T_odom_last.inverse());
    }
    return guess;
  };
  const ModelView* view = &model;
  const auto view_at = [&](const Pose& T) -> const ModelView& {
    if (!is_within(view->T_odom_camera.inverse() * T, kSameView_m, kSameView_rad)) view = &predict(T);
    return *view;
  };
  Estimate best;
  const auto attempt = [&](const PhotometricReference* reference, const Pose& T_guess, const ModelView& seen,
                           PoseSource source) {
    const Estimate estimate = by_model(maps, seen, reference, guess_at(T_guess), source);
    const auto rank = [](const Estimate& e) {
      return std::tuple(e.result.status, -e.result.quality.inlier_share);
    };
    if (best.source == PoseSource::kNone || rank(estimate) < rank(best)) best = estimate;
    best.is_sure = best.result.status == TrackingStatus::kGood && !is_return(maps) &&
                   best.result.quality.inlier_share >= config_.sure_inlier_share;
  };

  const Pose T_odom_guess = T_odom_last * rotation_aligner_.align(maps, predicted_motion(dt_s));
  attempt(&reference_, T_odom_guess, view_at(T_odom_last * carried_motion()), PoseSource::kModel);
  const auto is_enough = [&] {
    return best.is_sure && best.result.quality.free_directions == 0 && dt_s <= kReach_s;
  };
  if (best.is_sure) is_model_rough_ = false;
  if (is_enough()) return best;
  tried_fallbacks_ = true;

  if (is_model_rough_ && best.result.status != TrackingStatus::kGood && dt_s <= kLongestPairwise_s) {
    attempt(&reference_, T_odom_guess, views_.view(last_surface_, T_odom_last), PoseSource::kPairwise);
    best.is_against_model = best.source == PoseSource::kModel;
    if (is_enough()) return best;
  }
  const auto found = keyframes_.find_near(last_good_.segment, T_odom_guess);
  if (found && found->alignment.status == FeatureStatus::kOk) {
    // Features and surface are independent witnesses.
    const auto agree = [&] {
      return best.result.status == TrackingStatus::kGood &&
             is_within(found->T_odom_camera.inverse() * best.result.T_odom_camera, kAgreement_m,
                       kAgreement_rad);
    };
    if (!agree()) {
      attempt(&reference_, found->T_odom_camera, view_at(found->T_odom_camera), PoseSource::kFeatures);
      if (!agree() && !best.is_sure) return uncertain(best, *found);
    }
    best.is_sure = best.has_witness = true;
  } else if (best.is_sure) {
    return best;  // nothing else tells more
  } else if (dt_s <= kLongestPairwise_s) {
    const TrackResult pairwise =
        tracker_.track(maps, views_.view(last_surface_, T_odom_last), nullptr, guess_at(T_odom_last));
    if (pairwise.status == TrackingStatus::kGood)
      attempt(nullptr, pairwise.T_odom_camera, view_at(pairwise.T_odom_camera), PoseSource::kPairwise);
  } else {
    attempt(nullptr, T_odom_last, view_at(T_odom_last), PoseSource::kModel);  // it may never have moved
  }
  return best;
}

bool Odometry::is_return(const FrameMaps& maps) const {
  const bool is_gap = last_interval_us_ > 0 && 2 * (maps.timestamp_us - last_us_) > 5 * last_interval_us_;
  return frames_since_good_ > 0 || is_gap;
}

void Odometry::doubt(const FrameMaps& maps, Estimate& estimate) const {
  TrackResult& result = estimate.result;
  if (result.status != TrackingStatus::kGood) return;
  // Without a good frame the motion model carries on alone.
  if (result.quality.free_directions > 0 && !estimate.has_witness)
    estimate.unconstrained_us = unconstrained_us_ + maps.timestamp_us - last_good_.timestamp_us;
  // A fair fit may be a wrong one then; a right one fits about as well as the last good frame did.
  const double last_share = is_model_rough_ ? 0 : kReturnShare * last_good_.quality.inlier_share;
  const double asked = std::max(config_.return_inlier_share, last_share);
  if (static_cast<double>(estimate.unconstrained_us) * 1e-6 > config_.max_unconstrained_s) {
    result.status = TrackingStatus::kUncertain;
    result.cause = TrackingCause::kUnconstrained;
  } else if (is_return(maps) && !estimate.is_sure && result.quality.inlier_share < asked) {
    result.status = TrackingStatus::kUncertain;
    result.cause = TrackingCause::kUnconfirmed;
  }
}

Odometry::Estimate Odometry::uncertain(const Estimate& contradicted,
                                       const KeyframeTracker::Found& found) const {
  Estimate estimate = contradicted;
  if (estimate.result.status == TrackingStatus::kGood) estimate.result.cause = TrackingCause::kUnconfirmed;
  estimate.result.status = TrackingStatus::kUncertain;
  estimate.result.T_odom_camera = found.T_odom_camera;
  estimate.source = PoseSource::kFeatures;
  estimate.information = found.alignment.information;
  estimate.from_sequence = keyframes_.keyframe(found.keyframe).sequence;
  return estimate;
}

Pose Odometry::predicted_motion(double dt_s) const {
  return sensed_motion(exp_se3(velocity_ * std::min(dt_s, kLongestPrediction_s)));
}

Pose Odometry::sensed_motion(const Pose& T_last_guess) const {
  if (!motion_) return T_last_guess;
  Pose T_last_now = motion_->T_from_to;
  if (!motion_->has_translation) T_last_now.translation() = T_last_guess.translation();
  if (!motion_->has_rotation) {  // a velocity, which holds in the camera as it turns
    Vector6d twist;
    twist << log_so3(T_last_guess.linear()), motion_->T_from_to.translation();
    T_last_now = exp_se3(twist);
  }
  return T_last_now;
}

bool Odometry::is_carried() const { return motion_ && motion_->has_rotation && motion_->has_translation; }

Pose Odometry::carried_motion() const { return is_carried() ? motion_->T_from_to : Pose::Identity(); }

Odometry::Estimate Odometry::dead_reckoned(const Estimate& lost) const {
  Estimate estimate;
  estimate.result.T_odom_camera = last_good_.T_odom_camera * motion_->T_from_to;
  estimate.result.status = TrackingStatus::kUncertain;
  estimate.result.cause = lost.result.cause;
  estimate.result.quality = lost.result.quality;
  estimate.source = PoseSource::kPrior;
  estimate.segment = last_good_.segment;
  estimate.from_sequence = last_good_.sequence;
  estimate.information = motion_->information;
  return estimate;
}

Odometry::Estimate Odometry::by_model(const FrameMaps& maps, const ModelView& model,
                                      const PhotometricReference* reference, const TrackGuess& guess,
                                      PoseSource source) {
  Estimate estimate;
  estimate.source = source;
  estimate.segment = last_good_.segment;
  estimate.from_sequence = last_good_.sequence;
  estimate.result = tracker_.track(maps, model, reference, guess);
  estimate.information =
      transported(estimate.result.information, model.T_odom_camera.inverse() * last_good_.T_odom_camera);
  const Pose T_expected_current =
      (last_good_.T_odom_camera * carried_motion()).inverse() * estimate.result.T_odom_camera;
  if (estimate.result.status != TrackingStatus::kLost &&
      !is_possible_step(T_expected_current, seconds(last_good_.timestamp_us, maps.timestamp_us), config_)) {
    estimate.result.status = TrackingStatus::kLost;
    estimate.result.cause = TrackingCause::kLargeStep;
  }
  return estimate;
}

bool Odometry::shows_a_place(const FrameMaps& maps) {
  const bool may_be_a_hand =
      segments_ > 0 && maps.has_colour && keyframes_.feature_count() < kFeaturesOfAPlace;
  return Tracker::measured_share(maps, may_be_a_hand ? kNotAHand_m : 0) >= config_.min_measured_share;
}

StampedPose Odometry::start_segment(const FrameMaps& maps, int64_t sequence) {
  Estimate estimate;
  if (shows_a_place(maps)) {
    estimate.result.status = TrackingStatus::kGood;
    estimate.result.cause = TrackingCause::kNone;
    estimate.result.T_odom_camera = T_odom_start_;
    estimate.source = PoseSource::kStart;
    estimate.from_sequence = sequence;
    estimate.segment = segments_++;
    estimate.is_sure = true;
  }
  return conclude(maps, estimate, sequence);
}

StampedPose Odometry::conclude(const FrameMaps& maps, const Estimate& estimate, int64_t sequence) {
  result_ = estimate.result;
  const int64_t interval_us = maps.timestamp_us - last_us_;
  const double dt_s = seconds(last_good_.timestamp_us, maps.timestamp_us);
  const bool is_followed =
      estimate.source != PoseSource::kStart && estimate.source != PoseSource::kRelocalised;

  StampedPose pose;
  pose.sequence = sequence;
  pose.timestamp_us = maps.timestamp_us;
  pose.from_sequence = estimate.from_sequence;
  pose.status = result_.status;
  pose.T_odom_camera = result_.T_odom_camera;
  pose.segment = estimate.segment;
  pose.source = estimate.source;
  pose.cause = result_.cause;
  pose.quality = result_.quality;
  pose.information = estimate.information;
  if (pose.status == TrackingStatus::kGood) {
    if (is_followed) {
      pose.information = edge_information(
          estimate.information, motion_ ? motion_->information : Matrix6d(Matrix6d::Zero()),
          last_good_.T_odom_camera.inverse() * pose.T_odom_camera, dt_s, estimate.is_against_model);
    }
    const Approach approach{last_good_.T_odom_camera, velocity_, is_followed ? dt_s : 0};
    steady_velocity_ = approach.velocity_at(pose.T_odom_camera);
    velocity_ = is_followed
                    ? Vector6d(log_se3(last_good_.T_odom_camera.inverse() * pose.T_odom_camera) / dt_s)
                    : Vector6d(Vector6d::Zero());
    if (!is_followed) reference_.forget();
    if (pose.source == PoseSource::kStart || pose.segment != last_good_.segment) is_model_rough_ = true;
    unconstrained_us_ = estimate.unconstrained_us;
    last_good_ = pose;
    exposure_ = result_.exposure;
    frames_since_good_ = 0;
    usable_lost_us_ = 0;
    candidate_.reset();
  } else {
    ++frames_since_good_;
    if (pose.status == TrackingStatus::kUncertain) {
      if (pose.source != PoseSource::kPrior) pose.information *= kUncertainInformation;
    } else {
      pose.T_odom_camera = last_good_.T_odom_camera;
      pose.from_sequence = last_good_.sequence;
      pose.segment = last_good_.segment;
      pose.source = PoseSource::kNone;
      pose.information = Matrix6d::Identity();  // 1 rad and 1 m
      if (segments_ == 0) {                     // nothing to stand at yet
        pose.from_sequence = sequence;
        pose.information.setZero();
      }
    }
  }
  last_interval_us_ = interval_us;
  last_us_ = maps.timestamp_us;
  return pose;
}

}  // namespace kt
