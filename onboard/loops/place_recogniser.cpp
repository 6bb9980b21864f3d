// The order of work on a keyframe, and when its result is due.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/loops/place_recogniser.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <utility>

#include "onboard/loops/builtin_vocabulary.h"
#include "shared/core/make_room.h"

namespace kt {
namespace {

constexpr int64_t kFramesToResult = 15;  // half a second: a keyframe takes a part of it

// The newest keyframes show what the odometry has just measured.
constexpr int kNewest = 5;

// What the keyframe before looks like says little where the camera turns fast: no place need look less alike.
constexpr float kLeastReference = 0.05f;

// A keyframe as near, by the paper's metric, may show the same, whatever it looks like.
constexpr double kNear = 0.9;

// One keyframe needs no more proofs than this.
constexpr int kEnough = 2;

// Odometry may err by so much without saying so.
constexpr double kUnsaid_m = 0.15, kUnsaidPerWay = 0.02, kUnsaid_rad = 0.1, kUnsaidPerWay_rad_per_m = 0.01;
constexpr double kSaidSigmas = 5;

// Standard deviation in the direction where it is largest.
double largest_sigma(const Eigen::Matrix3d& covariance) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance, Eigen::EigenvaluesOnly);
  return std::sqrt(std::max(0.0, solver.eigenvalues().maxCoeff()));
}

}  // namespace

PlaceRecogniser::PlaceRecogniser(const Calibration& calibration, const LoopConfig& config)
    : config_(config),
      maker_(calibration, static_cast<PlaceFeature>(config.feature)),
      vocabulary_(builtin_vocabulary(maker_.kind().type)),
      verifier_(calibration, maker_.kind(), config.verification),
      index_(vocabulary_.word_count()),
      thread_([this] { work(); }) {}

PlaceRecogniser::~PlaceRecogniser() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

void PlaceRecogniser::follow(const StampedPose& pose) {
  if (!last_good_ || last_good_->segment != pose.segment) {
    way_m_ = 0;
    covariance_.setZero();
  } else {
    way_m_ += (last_good_->T_odom_camera.inverse() * pose.T_odom_camera).translation().norm();
    const Eigen::LLT<Matrix6d> llt(pose.information);
    const Matrix6d edge = llt.solve(Matrix6d::Identity());
    if (llt.info() == Eigen::Success && edge.allFinite()) {
      const Matrix6d Ad = adjoint(last_good_->T_odom_camera);
      covariance_ += Ad * edge * Ad.transpose();
    }
  }
  last_good_ = pose;
}

std::vector<PlaceRecogniser::Findings> PlaceRecogniser::next(const FrameMaps& maps, const Image<Rgb8>& colour,
                                                             const StampedPose& pose,
                                                             const FrameMotion& motion) {
  ++frame_;
  if (!config_.enabled) return {};
  if (pose.status == TrackingStatus::kGood) {
    follow(pose);
    const bool is_new =
        !last_keyframe_ || last_keyframe_->segment != pose.segment ||
        movement(last_keyframe_->T_odom_camera.inverse() * pose.T_odom_camera) >= config_.keyframe_distance;
    if (is_new && maps.has_colour) {
      last_keyframe_ = pose;
      Job job{frame_ + kFramesToResult, KeyframeMaker::images_of(maps, colour, pose, motion), way_m_,
              covariance_};
      const std::lock_guard lock(mutex_);
      jobs_.push_back(std::move(job));
      changed_.notify_all();
    }
  }
  return take(frame_);
}

std::vector<PlaceRecogniser::Findings> PlaceRecogniser::finish() { return take(frame_ + kFramesToResult); }

std::vector<PlaceRecogniser::Findings> PlaceRecogniser::take(int64_t due_frame) {
  std::vector<Findings> due;
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return failure_ || jobs_.empty() || jobs_.front().due_frame > due_frame; });
  if (failure_) std::rethrow_exception(failure_);
  while (!results_.empty() && results_.front().first <= due_frame) {
    due.push_back(std::move(results_.front().second));
    results_.pop_front();
  }
  return due;
}

void PlaceRecogniser::work() {
  std::unique_lock lock(mutex_);
  try {
    while (true) {
      changed_.wait(lock, [this] { return stopping_ || !jobs_.empty(); });
      if (stopping_) return;
      Job job = std::move(jobs_.front());
      const int64_t due_frame = job.due_frame;
      lock.unlock();
      Findings findings = study(std::move(job));
      lock.lock();
      results_.emplace_back(due_frame, std::move(findings));
      jobs_.pop_front();
      changed_.notify_all();
    }
  } catch (...) {
    if (!lock.owns_lock()) lock.lock();
    failure_ = std::current_exception();
    changed_.notify_all();
  }
}

void PlaceRecogniser::wait_until_idle() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return failure_ || jobs_.empty(); });
  if (failure_) std::rethrow_exception(failure_);
}

std::optional<SegmentPose> PlaceRecogniser::find(const FrameMaps& maps) {
  if (!config_.enabled || !maps.has_colour) return std::nullopt;
  wait_until_idle();
  if (known_.empty()) return std::nullopt;
  StampedPose nowhere;
  nowhere.sequence = known_.back().place.keyframe.sequence + 1;
  const Known seen = known_as(maker_.make(KeyframeMaker::images_of(maps, {}, nowhere)));
  std::optional<SegmentPose> best;
  size_t most = 0;
  for (const auto& match :
       index_.search(seen.bag, static_cast<int>(known_.size()), 0.0f, config_.candidates)) {
    const Place& from = known_[static_cast<size_t>(match.keyframe)].place;
    const LoopClosure proof = verifier_.verify(from, seen.place);
    if (!proof.accepted() || proof.p_from.size() <= most) continue;
    most = proof.p_from.size();
    best = SegmentPose{from.keyframe.segment, from.keyframe.T_odom_camera * proof.T_from_to};
  }
  return best;
}

PlaceRecogniser::Known PlaceRecogniser::known_as(Keyframe keyframe) const {
  ImageWords words = vocabulary_.words_of(keyframe.descriptors);
  return {{std::move(keyframe), std::move(words.nodes)}, std::move(words.bag)};
}

PlaceRecogniser::Findings PlaceRecogniser::study(Job job) {
  Known known = known_as(maker_.make(job.images));
  known.way_m = job.way_m;
  known.covariance = job.covariance;
  Findings findings{known.place.keyframe, {}};
  known.place.keyframe.thumbnail = {};  // of no use here, and many
  int accepted = 0;
  for (const auto& [keyframe, similarity] : proposals(known)) {
    const Known& from = known_[static_cast<size_t>(keyframe)];
    LoopClosure loop = verifier_.verify(from.place, known.place);
    loop.sequence = candidates_++;
    loop.similarity = similarity;
    if (loop.accepted() && is_excluded_by_odometry(from, known, loop.T_from_to))
      loop.verdict = LoopVerdict::kWeak;
    accepted += loop.accepted();
    findings.candidates.push_back(std::move(loop));
    if (accepted == kEnough) break;
  }
  remember(std::move(known));
  return findings;
}

void PlaceRecogniser::remember(Known known) {
  if (make_room(known_, static_cast<size_t>(config_.max_keyframes))) {
    index_ = KeyframeIndex(vocabulary_.word_count());
    for (const Known& kept : known_) index_.add(kept.bag);
  }
  index_.add(known.bag);
  known_.push_back(std::move(known));
}

std::vector<KeyframeIndex::Match> PlaceRecogniser::proposals(const Known& known) const {
  const int end = static_cast<int>(known_.size()) - kNewest;
  if (end <= 0) return {};
  const float reference = std::max(kLeastReference, similarity(known.bag, known_.back().bag));
  std::vector<KeyframeIndex::Match> found = index_.search(
      known.bag, end, static_cast<float>(config_.min_similarity) * reference, config_.candidates);
  for (KeyframeIndex::Match& match : found) match.similarity /= reference;
  int nearest = -1;
  double least = kNear;
  for (int i = 0; i < end; ++i) {
    const Keyframe& other = known_[static_cast<size_t>(i)].place.keyframe;
    if (other.segment != known.place.keyframe.segment) continue;
    const double distance = movement(other.T_odom_camera.inverse() * known.place.keyframe.T_odom_camera);
    if (distance >= least) continue;
    least = distance;
    nearest = i;
  }
  const bool is_among =
      std::any_of(found.begin(), found.end(), [&](const auto& m) { return m.keyframe == nearest; });
  if (nearest >= 0 && !is_among) found.push_back({nearest, 0});
  return found;
}

bool PlaceRecogniser::is_excluded_by_odometry(const Known& from, const Known& to,
                                              const Pose& T_from_to) const {
  const Keyframe &a = from.place.keyframe, &b = to.place.keyframe;
  if (a.segment != b.segment) return false;
  const Vector6d difference =
      log_se3(T_from_to * (a.T_odom_camera.inverse() * b.T_odom_camera).inverse());  // seen from camera a
  const Matrix6d Ad = adjoint(a.T_odom_camera.inverse());
  const Matrix6d covariance = Ad * (to.covariance - from.covariance) * Ad.transpose();
  const double way_m = to.way_m - from.way_m;
  const double said_rad = largest_sigma(covariance.topLeftCorner<3, 3>()),
               said_m = largest_sigma(covariance.bottomRightCorner<3, 3>());
  return difference.head<3>().norm() >
             kSaidSigmas * said_rad + kUnsaid_rad + kUnsaidPerWay_rad_per_m * way_m ||
         difference.tail<3>().norm() > kSaidSigmas * said_m + kUnsaid_m + kUnsaidPerWay * way_m;
}

}  // namespace kt
