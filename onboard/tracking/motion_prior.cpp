// Goes along the samples of a span, stretch by stretch.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/tracking/motion_prior.h"

#include <algorithm>
#include <cmath>

namespace kt {
namespace {

constexpr int64_t kKept_us = 60'000'000;

// Streams come at 10 Hz or more, so this bridges a late sample or two. A robot that brakes at 1 m/s^2 is then
// 2 cm from where its last velocity carries it: still within reach of the tracker.
constexpr int64_t kLongestExtrapolation_us = 200'000;

// Within this long a robot may start, turn and stop: what lies between two samples is no longer known.
constexpr int64_t kLongestHole_us = 500'000;

// No robot turns or goes faster (rad/s, m/s): its odometry was set to another place, and what lies between is
// not known.
constexpr double kFastest = 100;

double seconds(int64_t span_us) { return static_cast<double>(span_us) * 1e-6; }

}  // namespace

/// From one sample to the next, or from the newest as far as it is believed.
struct MotionPrior::Stretch {
  int64_t begin_us, end_us;
  Vector6d twist;  // of the camera in its own frame (rad/s; m/s)
  const MotionSample* sample;
};

bool MotionPrior::add(const MotionSample& sample) {
  if (!sample.measures_motion()) return false;
  if (!samples_.empty() &&
      (sample.timestamp_us <= samples_.back().timestamp_us || sample.kind != samples_.front().kind))
    return false;
  samples_.push_back(sample);
  while (samples_.front().timestamp_us < sample.timestamp_us - kKept_us) samples_.pop_front();
  return true;
}

std::optional<MotionPrior::Stretch> MotionPrior::stretch_after(size_t i, int64_t to_us) const {
  const bool is_newest = i + 1 == samples_.size();
  const MotionSample& sample = samples_[i];
  const int64_t end_us =
      is_newest ? sample.timestamp_us + kLongestExtrapolation_us : samples_[i + 1].timestamp_us;
  if (is_newest ? to_us > end_us : end_us - sample.timestamp_us > kLongestHole_us) return std::nullopt;
  Stretch stretch{sample.timestamp_us, end_us, sample.velocity, &sample};
  if (sample.kind == MotionSample::Kind::kPose) {
    if (is_newest) {
      if (i == 0) return std::nullopt;
      const std::optional<Stretch> last = stretch_after(i - 1, sample.timestamp_us);
      if (!last) return std::nullopt;
      stretch.twist = last->twist;
    } else {
      const Pose T_begin_end = sample.T_prior.inverse() * samples_[i + 1].T_prior;
      stretch.twist = log_se3(T_begin_end) / seconds(end_us - sample.timestamp_us);
    }
  }
  return stretch;
}

std::optional<RelativeMotion> MotionPrior::between(int64_t from_us, int64_t to_us) const {
  if (from_us >= to_us || samples_.empty() || from_us < samples_.front().timestamp_us) return std::nullopt;
  const auto after = std::upper_bound(
      samples_.begin(), samples_.end(), from_us,
      [](int64_t stamp_us, const MotionSample& sample) { return stamp_us < sample.timestamp_us; });
  const auto first = static_cast<size_t>(after - samples_.begin()) - 1;
  RelativeMotion motion{.has_rotation = true, .has_translation = true};
  for (size_t i = first; i < samples_.size() && samples_[i].timestamp_us < to_us; ++i) {
    motion.has_rotation &= samples_[i].rotation_sigma > 0;
    motion.has_translation &= samples_[i].translation_sigma > 0;
  }
  if (!motion.has_rotation && !motion.has_translation) return std::nullopt;

  Matrix6d covariance = Matrix6d::Zero();
  for (size_t i = first; i < samples_.size() && samples_[i].timestamp_us < to_us; ++i) {
    const std::optional<Stretch> stretch = stretch_after(i, to_us);
    if (!stretch) return std::nullopt;
    Vector6d twist = stretch->twist;
    if (!motion.has_rotation) twist.head<3>().setZero();
    if (!motion.has_translation) twist.tail<3>().setZero();
    if (twist.cwiseAbs().maxCoeff() > kFastest) return std::nullopt;
    const double dt_s = seconds(std::min(stretch->end_us, to_us) - std::max(stretch->begin_us, from_us));
    // An error on the way acts on the frame of `from` through where the camera was: its middle stands for the
    // stretch.
    const Matrix6d to_from = adjoint(motion.T_from_to * exp_se3(twist * (dt_s / 2)));
    Vector6d variance;
    // Claims beyond reason would leave the numbers' range.
    const auto square = [](double sigma) { return std::pow(std::clamp(sigma, 1e-6, 1e3), 2); };
    variance << Eigen::Vector3d::Constant(square(stretch->sample->rotation_sigma)),
        Eigen::Vector3d::Constant(square(stretch->sample->translation_sigma));
    covariance += to_from * (variance * dt_s).asDiagonal() * to_from.transpose();
    motion.T_from_to = orthonormalised(motion.T_from_to * exp_se3(twist * dt_s));
  }
  if (motion.has_rotation && motion.has_translation) {
    const Matrix6d information = covariance.inverse();
    motion.information = (information + information.transpose()) / 2;
  } else if (motion.has_rotation) {
    motion.information.topLeftCorner<3, 3>() = covariance.topLeftCorner<3, 3>().inverse();
  } else {
    motion.information.bottomRightCorner<3, 3>() = covariance.bottomRightCorner<3, 3>().inverse();
  }
  return motion;
}

}  // namespace kt
