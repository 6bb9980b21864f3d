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
  double min_inlier_share = 0.5;      ///< of the pixels on model surface: below, the pose is uncertain
  double return_inlier_share = 0.65;  ///< the same for the first frame after a gap or a doubtful frame
  double sure_inlier_share = 0.7;     ///< below, other guesses of the motion are tried too
  double min_measured_share = 0.05;   ///< of the pixels of the first frame: below, it starts nothing
  double min_overlap = 0.15;  ///< share of measured pixels on model surface: below, the pose is uncertain
  double reference_distance_m = 0.15;  ///< the image reference is replaced after this motion
  double reference_angle_deg = 10;     ///< or this turn
  double max_step_m = 0.25;            ///< motion in 1/30 s beyond which a pose is not believed
  double max_step_deg = 20;
};

struct TrackResult {
  Pose T_odom_camera = Pose::Identity();
  TrackingStatus status = TrackingStatus::kLost;
  /// Of the left perturbation of T_model_current, model = the camera of the model view.
  Matrix6d information = Matrix6d::Zero();
  double inlier_share = 0;    ///< of the pixels that fall on model surface
  double overlap = 0;         ///< share of the pixels measured inside the volume that do so
  Exposure exposure;          ///< of the frame against the reference
  double rms_m = 0;           ///< weighted point-to-plane residual of the inliers
  int free_directions = 0;    ///< of the six, how many kept the guess
  double min_eigenvalue = 0;  ///< of the normalised Hessian: 0 where geometry leaves a direction free
};

class Tracker {
 public:
  Tracker(const exec::Device& device, const Calibration& calibration, const TrackingConfig& config);

  /// Aligns a frame with the model view and, where both have colour, with the reference (may be null),
  /// starting at `T_odom_guess` and `exposure`. The camera is believed to have moved from the model's pose by
  /// `step_factor` times the configured steps at most.
  TrackResult track(const FrameMaps& maps, const ModelView& model, const PhotometricReference* reference,
                    const Pose& T_odom_guess, const Exposure& exposure = {}, double step_factor = 1);

  /// Share of the pixels at which the frame measured a surface.
  double measured_share(const FrameMaps& maps);

 private:
  void judge(const FrameMaps& maps, const ModelView& model, const Pose& T_model_current, double step_factor,
             TrackResult* result);

  exec::Device device_;
  TrackingConfig config_;
  exec::ReductionWorkspace workspace_;
};

}  // namespace kt
