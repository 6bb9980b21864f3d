// Follows the camera from frame to frame: where it may be, where the tracker finds it, and whether that is
// believed.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "onboard/tracking/motion_prior.h"
#include "onboard/tracking/photometric_reference.h"
#include "onboard/tracking/rotation_aligner.h"
#include "onboard/tracking/tracker.h"

namespace kt {

class Odometry {
 public:
  Odometry(const exec::Device& device, const Calibration& calibration, const TrackingConfig& config);

  /// Finds the pose of the next frame, whose stamp lies after the last one's. `model` is the surface as
  /// predicted from the last good pose, null as long as there was none: the first frame that measures enough
  /// is good, and its camera is the odom frame. The pose's edge starts at the last good frame; a lost frame
  /// repeats its pose, with next to no information.
  StampedPose track(const FrameMaps& maps, const ModelView* model, int64_t sequence, int64_t timestamp_us);

  /// Looks at a frame that was fused, and the model view predicted from its pose: later frames are compared
  /// with them.
  void remember(const FrameMaps& maps, const ModelView& model);

  /// Takes a sample of another sensor, before the first frame whose stamp is not before its own. False where
  /// it is refused, as MotionPrior::add does.
  bool add_motion_sample(const MotionSample& sample) { return motion_prior_.add(sample); }

  /// What the tracker found for the last frame, whatever became of it.
  const TrackResult& last_result() const { return result_; }
  /// Sequence and pose of the last good frame.
  const StampedPose& last_good() const { return last_good_; }

 private:
  TrackResult best_of_guesses(const FrameMaps& maps, const ModelView& model, double dt_s);
  bool is_return(int64_t timestamp_us) const;

  TrackingConfig config_;
  Tracker tracker_;
  RotationAligner rotation_aligner_;
  PhotometricReference reference_;
  MotionPrior motion_prior_;
  Exposure exposure_;  // of the last good frame against the reference
  TrackResult result_;
  StampedPose last_good_;
  Vector6d velocity_ = Vector6d::Zero();  // of the camera in its own frame, per second
  int64_t last_us_ = 0, last_interval_us_ = 0;
  bool last_was_good_ = true;
};

}  // namespace kt
