// Gauss-Newton over the pyramid, and the judgement of its result.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/tracking/tracker.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "onboard/tracking/icp_kernel.h"

namespace kt {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

// Fits are judged at the coarsest level: cheap, and the shares are the same.
constexpr int kJudgedLevel = kPyramidLevels - 1;

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

PointToPlane cost(const TrackingConfig& config, const FrameMaps& maps, const ModelView& model, int level,
                  const Pose& T_model_current) {
  const SurfaceLevel& surface = maps.levels[static_cast<size_t>(level)];
  return {{surface.depth_view(), surface.normals.data(), surface.camera, to_rigid3f(T_model_current),
           model.camera, model.points.data(), model.normals.data()},
          static_cast<float>(config.max_distance_m),
          static_cast<float>(std::cos(config.max_normal_angle_deg * kDegree)),
          static_cast<float>(1 << level),
          static_cast<float>(config.robust_sigmas)};
}

}  // namespace

Tracker::Tracker(const exec::Device& device, const PinholeParams& camera, const TrackingConfig& config)
    : device_(device), config_(config), workspace_(device, camera.pixel_count()) {}

exec::NormalEquations Tracker::residuals(const FrameMaps& maps, const ModelView& model, int level,
                                         const Pose& T_model_current) {
  const PointToPlane functor = cost(config_, maps, model, level, T_model_current);
  return exec::reduce_normal_equations(device_, functor.association.camera.pixel_count(), functor,
                                       workspace_);
}

TrackResult Tracker::track(const FrameMaps& maps, const ModelView& model, const Pose& T_odom_guess,
                           double step_factor) {
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
  result.rms_m = std::sqrt(equations.weighted_squares / equations.weights);
  // Residuals larger than the noise model predicts scale the information down (reduced chi square).
  const double chi_square = std::max(1.0, equations.weighted_squares / static_cast<double>(equations.count));
  result.information = hessian(equations) / (kPixelCorrelation * chi_square);
  judge(maps, model, T_model_current, step_factor, &result);
  return result;
}

void Tracker::judge(const FrameMaps& maps, const ModelView& model, const Pose& T_model_current,
                    double step_factor, TrackResult* result) {
  const JudgePixel functor{cost(config_, maps, model, kJudgedLevel, T_model_current)};
  const exec::NormalEquations sums = exec::reduce_normal_equations(
      device_, functor.cost.association.camera.pixel_count(), functor, workspace_);
  const double measured = sums.weights, associated = sums.weighted_squares, inliers = sums.A[0][0];
  result->overlap = measured > 0 ? associated / measured : 0;
  result->inlier_share = associated > 0 ? inliers / associated : 0;

  const bool believable = T_model_current.translation().norm() <= step_factor * config_.max_step_m &&
                          rotation_angle(T_model_current) <= step_factor * config_.max_step_deg * kDegree;
  if (!believable || result->inlier_share < 0.5 * config_.min_inlier_share ||
      result->overlap < 0.5 * config_.min_overlap) {
    result->status = TrackingStatus::kLost;
  } else if (result->inlier_share < config_.min_inlier_share || result->overlap < config_.min_overlap) {
    result->status = TrackingStatus::kUncertain;
  } else {
    result->status = TrackingStatus::kGood;
  }
}

double Tracker::measured_share(const FrameMaps& maps) {
  const SurfaceLevel& surface = maps.levels[kJudgedLevel];
  const std::vector<Vec4f> normals = surface.normals.downloaded();
  const auto measured = std::count_if(normals.begin(), normals.end(), [](const Vec4f& n) { return n.w > 0; });
  return static_cast<double>(measured) / static_cast<double>(normals.size());
}

}  // namespace kt
