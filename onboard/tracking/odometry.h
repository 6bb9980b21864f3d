// Follows the camera from frame to frame: where it may be, where it is found, by which means, and whether
// that is believed.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <optional>

#include "onboard/tracking/frame_view.h"
#include "onboard/tracking/keyframe_tracker.h"
#include "onboard/tracking/motion_prior.h"
#include "onboard/tracking/photometric_reference.h"
#include "onboard/tracking/rotation_aligner.h"
#include "onboard/tracking/tracker.h"

namespace kt {

class Odometry {
 public:
  /// The model surface as seen from a pose; the view replaces the one before it.
  using PredictSurface = std::function<const ModelView&(const Pose& T_odom_camera)>;

  /// Where a camera is that sees a frame, wherever that may be; nothing where the place is not recognised.
  /// May be empty: a lost camera is then not looked for.
  using FindPlace = std::function<std::optional<SegmentPose>(const FrameMaps&)>;

  Odometry(const exec::Device& device, const Calibration& calibration, const TrackingConfig& config);

  /// Finds the pose of the next frame, whose stamp lies after the last one's. `model` is the surface as last
  /// predicted, null as long as there was none: the first frame that measures enough is good, and the
  /// body of its camera is the odom frame of its segment. The pose's edge starts at the last good frame or,
  /// of a camera found again, at a keyframe; a lost frame repeats the last good pose, with next to no
  /// information. A good pose of another segment than the last one's needs another model: that of its own
  /// segment, or an empty one.
  StampedPose track(const FrameMaps& maps, const ModelView* model, const PredictSurface& predict,
                    const FindPlace& find_place, int64_t sequence);

  /// Looks at a good frame, and the model view predicted from its pose, null where it was not fused: later
  /// frames are compared with them. Right after track() of that frame.
  void remember(const FrameMaps& maps, const ModelView* model);

  /// Aligns frames at the coarsest resolution alone from now on, or as configured.
  void set_coarse(bool is_coarse) { tracker_.set_finest_level(is_coarse ? kPyramidLevels - 1 : 0); }

  /// Takes a sample of another sensor, before the first frame whose stamp is not before its own. False where
  /// it is refused, as MotionPrior::add does.
  bool add_motion_sample(const MotionSample& sample) { return motion_prior_.add(sample); }

  /// The fit behind the last frame's pose, with the verdict on it.
  const TrackResult& last_result() const { return result_; }
  /// Whether more than the one attempt that serves most frames was made for it.
  bool tried_fallbacks() const { return tried_fallbacks_; }
  /// Sequence and pose of the last good frame.
  const StampedPose& last_good() const { return last_good_; }
  /// Of the camera at the last good frame, in its own frame, [rad/s; m/s]; the mean of two motions
  /// (Approach).
  const Vector6d& velocity() const { return steady_velocity_; }

 private:
  /// A pose with all that is known of it.
  struct Estimate {
    TrackResult result;
    PoseSource source = PoseSource::kNone;
    Matrix6d information = Matrix6d::Zero();  // of the edge from `from`
    int64_t from_sequence = 0;
    int segment = 0;
    bool is_sure = false;          // the fallbacks have nothing to add
    bool has_witness = false;      // features say the same
    bool is_against_model = true;  // else against the last frame
    int64_t unconstrained_us =
        0;  // how long good frames have left a direction to the motion model, with this one
  };
  /// A camera found again, whose next frame is to confirm it.
  struct Candidate {
    Pose T_odom_camera = Pose::Identity();
    int64_t timestamp_us = 0;
    int keyframe = -1;
  };

  /// Where the camera should be now, seen from the last good frame.
  Pose predicted_motion(double dt_s) const;
  /// What another sensor says of that, completed by the guess.
  Pose sensed_motion(const Pose& T_last_guess) const;
  /// Whether another sensor measures all of the motion; what it says then, else none.
  bool is_carried() const;
  Pose carried_motion() const;
  Estimate dead_reckoned(const Estimate& lost) const;
  Estimate follow(const FrameMaps& maps, const ModelView& model, const PredictSurface& predict);
  /// Whether this is the first frame after a gap, or after frames that were not good.
  bool is_return(const FrameMaps& maps) const;
  /// Takes back what is not to be believed after what came before.
  void doubt(const FrameMaps& maps, Estimate& estimate) const;
  /// The features' pose, where the surface does not bear it out.
  Estimate uncertain(const Estimate& contradicted, const KeyframeTracker::Found& found) const;
  Estimate by_model(const FrameMaps& maps, const ModelView& model, const PhotometricReference* reference,
                    const TrackGuess& guess, PoseSource source);
  std::optional<Estimate> confirm(const FrameMaps& maps, const PredictSurface& predict);
  std::optional<Estimate> relocalise(const FrameMaps& maps, const PredictSurface& predict,
                                     const FindPlace& find_place);
  Estimate by_keyframe(const FrameMaps& maps, const PredictSurface& predict, int index,
                       const Pose& T_odom_guess);
  /// Whether the frame shows a place at all, rather than a hand before the lens.
  bool shows_a_place(const FrameMaps& maps);
  StampedPose start_segment(const FrameMaps& maps, int64_t sequence);
  StampedPose conclude(const FrameMaps& maps, const Estimate& estimate, int64_t sequence);

  TrackingConfig config_;
  Pose T_odom_start_;  // of a segment
  Tracker tracker_;
  RotationAligner rotation_aligner_;
  PhotometricReference reference_;
  KeyframeTracker keyframes_;
  FrameViews views_;
  SurfaceMemory last_surfaces_;
  KeptSurface last_surface_;  // of the last good frame
  // The model is new and has not yet fitted a frame well. Of a few frames, from farther than some 2 m, its
  // normals err by more than max_normal_angle_deg; where it fails, the filtered surface of the last frame
  // serves.
  bool is_model_rough_ = true;
  Exposure exposure_;  // of the last good frame against the reference
  MotionPrior motion_prior_;
  TrackResult result_;
  std::optional<RelativeMotion> motion_;  // what another sensor says, from the last good frame to this one
  StampedPose last_good_;
  Vector6d velocity_ = Vector6d::Zero();         // of the camera in its own frame, per second
  Vector6d steady_velocity_ = Vector6d::Zero();  // as velocity() says
  std::optional<Candidate> candidate_;
  int segments_ = 0;
  int64_t last_us_ = 0, last_interval_us_ = 0;
  int64_t unconstrained_us_ = 0;  // of the last good frame
  int64_t usable_lost_us_ = 0;    // time of usable frames since the last good one
  int frames_since_good_ = 0;
  bool tried_fallbacks_ = false;
};

}  // namespace kt
