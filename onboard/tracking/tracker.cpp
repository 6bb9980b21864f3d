// Gauss-Newton over the pyramid, and the judgement of its result.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/tracking/tracker.h"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <numbers>

#include "onboard/tracking/icp_kernel.h"

namespace kt {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

// Rotations are weighed against translations at this lever arm: 1 rad moves a point at this range by it.
constexpr double kLeverArmM = 2.0;

// Neighbouring pixels err together (filter, disparity interpolation), so their residuals hold less
// information than their number.
constexpr double kPixelCorrelation = 50.0;

Matrix6d hessian(const exec::NormalEquations& equations) {
  return Eigen::Map<const Matrix6d>(&equations.A[0][0]);
}

// Scales rotation to metres at the lever arm.
Vector6d lever_scale() {
  Vector6d scale;
  scale << Eigen::Vector3d::Constant(1 / kLeverArmM), Eigen::Vector3d::Ones();
  return scale;
}

// Gauss-Newton step; zero along the eigenvectors of the normalised Hessian that the residuals do not
// constrain.
Vector6d solve(const exec::NormalEquations& equations, double min_eigenvalue, double* smallest) {
  const Vector6d scale = lever_scale();
  const Matrix6d normalised =
      scale.asDiagonal() * (hessian(equations) / equations.weights) * scale.asDiagonal();
  const Vector6d gradient =
      scale.asDiagonal() * (Eigen::Map<const Vector6d>(equations.b) / equations.weights);
  const Eigen::SelfAdjointEigenSolver<Matrix6d> eigen(normalised);
  *smallest = eigen.eigenvalues()(0);
  Vector6d step = Vector6d::Zero();
  for (int k = 0; k < 6; ++k) {
    if (eigen.eigenvalues()(k) < min_eigenvalue) continue;
    const Vector6d direction = eigen.eigenvectors().col(k);
    step -= direction * (direction.dot(gradient) / eigen.eigenvalues()(k));
  }
  return scale.asDiagonal() * step;
}

}  // namespace

Tracker::Tracker(const exec::Device& device, const PinholeParams& camera, const TrackingConfig& config)
    : device_(device), config_(config), workspace_(device, camera.pixel_count()) {}

static ProjectiveAssociation association(const FrameMaps& maps, const ModelView& model, int level,
                                         const Pose& T_model_current) {
  const SurfaceLevel& surface = maps.levels[static_cast<size_t>(level)];
  return {surface.depth_view(), surface.normals.data(), surface.camera,      to_rigid3f(T_model_current),
          model.camera,         model.points.data(),    model.normals.data()};
}

exec::NormalEquations Tracker::residuals(const FrameMaps& maps, const ModelView& model, int level,
                                         const Pose& T_model_current) {
  const PointToPlane functor{association(maps, model, level, T_model_current),
                             static_cast<float>(config_.max_distance_m),
                             static_cast<float>(std::cos(config_.max_normal_angle_deg * kDegree)),
                             static_cast<float>(1 << level), static_cast<float>(config_.robust_sigmas)};
  return exec::reduce_normal_equations(device_, maps.levels[static_cast<size_t>(level)].camera.pixel_count(),
                                       functor, workspace_);
}

TrackResult Tracker::track(const FrameMaps& maps, const ModelView& model, const Pose& T_odom_guess,
                           const Pose& T_odom_last) {
  constexpr int64_t kFewestPixels = 200;
  TrackResult result;
  Pose T_model_current = model.T_odom_camera.inverse() * T_odom_guess;
  exec::NormalEquations equations;
  for (int level = kPyramidLevels - 1; level >= 0; --level) {
    for (int iteration = 0; iteration < config_.iterations[static_cast<size_t>(level)]; ++iteration) {
      equations = residuals(maps, model, level, T_model_current);
      if (equations.count < kFewestPixels) break;
      const Vector6d step = solve(equations, config_.min_eigenvalue, &result.min_eigenvalue);
      T_model_current = orthonormalised(exp_se3(step) * T_model_current);
      if (step.head<3>().norm() < 2e-5 && step.tail<3>().norm() < 4e-5) break;
    }
  }
  result.T_odom_camera = orthonormalised(model.T_odom_camera * T_model_current);
  if (equations.count < kFewestPixels) return result;

  // Judged at the coarsest level: cheap, and the shares are the same.
  constexpr int kJudged = kPyramidLevels - 1;
  const int64_t pixels = maps.levels[kJudged].camera.pixel_count();
  const ProjectiveAssociation pairs = association(maps, model, kJudged, T_model_current);
  const auto count = [&](bool only_associated) {
    return static_cast<double>(
        exec::reduce_normal_equations(device_, pixels, CountPixels{pairs, only_associated}, workspace_)
            .count);
  };
  const double measured = count(false), associated = count(true);
  const double inliers = static_cast<double>(residuals(maps, model, kJudged, T_model_current).count);
  result.overlap = measured > 0 ? associated / measured : 0;
  result.inlier_share = associated > 0 ? inliers / associated : 0;
  result.rms_m = std::sqrt(equations.weighted_squares / equations.weights);
  // Residuals larger than the noise model predicts scale the information down (reduced chi square).
  const double chi_square = std::max(1.0, equations.weighted_squares / static_cast<double>(equations.count));
  result.information = hessian(equations) / (kPixelCorrelation * chi_square);

  const Pose T_last_current = T_odom_last.inverse() * result.T_odom_camera;
  const bool believable = T_last_current.translation().norm() <= config_.max_step_m &&
                          rotation_angle(T_last_current) <= config_.max_step_deg * kDegree;
  if (!believable || result.inlier_share < 0.5 * config_.min_inlier_share ||
      result.overlap < 0.5 * config_.min_overlap) {
    result.status = TrackingStatus::kLost;
  } else if (result.inlier_share < config_.min_inlier_share || result.overlap < config_.min_overlap) {
    result.status = TrackingStatus::kUncertain;
  } else {
    result.status = TrackingStatus::kGood;
  }
  return result;
}

}  // namespace kt
