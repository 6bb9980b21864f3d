// What a keyframe's feature says of the camera, the point and the calibration.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ceres/cost_function.h>

#include "offboard/refinement/feature_tracks.h"

namespace kt {

/// What the calibration is changed by.
struct CalibrationChange {
  double focal = 0;                                     ///< fx and fy of the colour camera, relative
  Eigen::Vector2d centre_px = Eigen::Vector2d::Zero();  ///< cx and cy
  /// The colour image was taken so much later than the stamps say, seen from the depth image (s).
  double colour_delay_s = 0;

  bool is_none() const { return focal == 0 && centre_px.isZero(0) && colour_delay_s == 0; }
};

/// What observations are predicted with. `velocity`: of the depth camera in its own frame, [rad/s; m/s].
struct ObservationModel {
  double fx, fy, cx, cy;
  Pose T_colour_depth;

  explicit ObservationModel(const Calibration& calibration)
      : fx(calibration.colour.fx),
        fy(calibration.colour.fy),
        cx(calibration.colour.cx),
        cy(calibration.colour.cy),
        T_colour_depth(calibration.T_colour_depth) {}

  /// Differences between where `seen` was seen and where it should be, in standard deviations: u, v, depth.
  /// False where the point lies behind the camera. Jacobians where asked for: by the point in the depth
  /// camera, and by [focal, cx, cy, delay].
  bool residual(const Observation& seen, const Eigen::Vector3d& p_camera, const Vector6d& velocity,
                const CalibrationChange& change, Eigen::Vector3d* r, Eigen::Matrix3d* by_point = nullptr,
                Eigen::Matrix<double, 3, 4>* by_change = nullptr) const;
};

/// Its residual as a Ceres cost of: the pose T_world_camera (kPoseParameters, perturbed from the left), the
/// point in the world (3), intrinsics (focal, cx, cy) and delay (1).
class ObservationCost : public ceres::CostFunction {
 public:
  ObservationCost(const ObservationModel& model, const Observation& seen, const Vector6d& velocity,
                  double scale);
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override;

 private:
  const ObservationModel& model_;
  const Observation& seen_;
  const Vector6d& velocity_;
  double scale_;
};

}  // namespace kt
