// Frame-to-model tracking by projective point-to-plane ICP, coarse to fine.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <optional>

#include "onboard/preprocess/model_view.h"
#include "onboard/preprocess/preprocessor.h"
#include "onboard/tracking/photometric_reference.h"
#include "shared/exec/normal_equations.h"
#include "shared/types/stamped_pose.h"

namespace kt {

struct TrackingConfig {
  std::array<int, kPyramidLevels> iterations{
      0, 8, 10};                     ///< at most, from the full resolution up; the model view has half of it
  double max_distance_m = 0.10;      ///< a pair of points farther apart does not count
  double max_normal_angle_deg = 30;  ///< nor one whose normals differ more
  double robust_sigmas = 2.5;        ///< scale of the Cauchy loss in standard deviations of the depth noise
  double photometric_weight = 1;     ///< of the photometric residuals beside the geometric ones; 0 = none
  double min_eigenvalue =
      1e-3;  ///< directions of the normalised Hessian below it keep the motion model's guess
  double max_unconstrained_s = 0.5;   ///< a direction may be left to the motion model for so long
  double min_inlier_share = 0.5;      ///< of the pixels on model surface: below, the pose is uncertain
  double return_inlier_share = 0.65;  ///< the same for the first frame after a gap or a doubtful frame
  double sure_inlier_share = 0.7;     ///< below, the fallbacks are tried too
  double min_measured_share = 0.05;   ///< of the pixels of a frame: below, it is no use
  double min_overlap = 0.15;  ///< share of measured pixels on model surface: below, the pose is uncertain
  double reference_distance_m = 0.15;  ///< the image reference is replaced after this motion
  double reference_angle_deg = 10;     ///< or this turn
  double max_step_m = 0.25;            ///< motion in 1/30 s beyond which a pose is not believed
  double max_step_deg = 20;
  double keyframe_distance = 0.2;    ///< between keyframes, in metres of motion plus radians of turn
  int max_keyframes = 1000;          ///< kept to find a lost camera again; 100 kB each, on a GPU from
                                     ///< the start
  int min_feature_inliers = 15;      ///< matches that must agree for a motion found by features
  double new_segment_after_s = 1.5;  ///< of usable frames without a good one: the map begins anew
};

/// How the camera came to where it is.
struct Approach {
  Pose T_odom_last = Pose::Identity();   ///< of the frame before
  Vector6d velocity = Vector6d::Zero();  ///< that it came there with, in its own frame, [rad/s; m/s]
  double dt_s = 0;                       ///< since then; 0: nothing is known, as if it stood still

  /// The mean of the last two motions, the second of which ends at T_odom_camera. Of one alone, an error of a
  /// pose would come back in the next one with the other sign, and grow: where the camera is held to be
  /// decides how fast it seems to move, and that, by its shutter, where its pixels are.
  Vector6d velocity_at(const Pose& T_odom_camera) const;
};

/// What is known of a frame's pose before it is looked at.
struct TrackGuess {
  Pose T_odom_camera = Pose::Identity();
  Exposure exposure{};
  Approach approach{};
  /// What another sensor says: soft term with this information of the left perturbation of T_odom_motion, in
  /// the odom frame. Zero: nothing.
  Pose T_odom_motion = Pose::Identity();
  Matrix6d motion_information = Matrix6d::Zero();
};

struct TrackResult {
  Pose T_odom_camera = Pose::Identity();
  TrackingStatus status = TrackingStatus::kLost;
  TrackingCause cause = TrackingCause::kNoDepth;
  /// Of the left perturbation of T_model_current, model = the camera of the model view: what the frame's own
  /// pixels tell.
  Matrix6d information = Matrix6d::Zero();
  Exposure exposure;  ///< of the frame against the reference
  TrackingQuality quality;
};

class Tracker {
 public:
  Tracker(const exec::Device& device, const Calibration& calibration, const TrackingConfig& config);

  /// Aligns a frame with the model view and, where both have colour, with the reference (may be null),
  /// starting at the guess.
  TrackResult track(const FrameMaps& maps, const ModelView& model, const PhotometricReference* reference,
                    const TrackGuess& guess);

  /// Share of the pixels at which the frame measured a surface, farther away than `beyond_m`.
  static double measured_share(const FrameMaps& maps, double beyond_m = 0);

 private:
  void judge(const FrameMaps& maps, const FrameMotion& motion, const ModelView& model,
             const Pose& T_model_current, TrackResult* result);

  exec::Device device_;
  TrackingConfig config_;
  exec::ReductionWorkspace geometric_workspace_, photometric_workspace_;
};

}  // namespace kt
