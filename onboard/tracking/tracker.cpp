// Gauss-Newton over the pyramid, and the judgement of its result.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/tracking/tracker.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include "onboard/tracking/icp_kernel.h"

namespace kt {
namespace {

constexpr double kRadPerDegree = std::numbers::pi / 180;

// Fits are judged at the coarsest level: cheap, and the shares are the same.
constexpr int kJudgedLevel = kPyramidLevels - 1;

// Rotations are weighed against translations at this lever arm: 1 rad moves a point at this range by it.
constexpr double kLeverArmM = 2.0;

// Neighbouring pixels err together, so their residuals hold less information than their number: those of
// geometry by filters and the interpolation of disparities, those of intensity by blur, reflections and the
// error of depth that all points of an edge share.
constexpr double kGeometricCorrelation = 50, kPhotometricCorrelation = 500;

// Square of the error of a normal (rad): as much of an eigenvalue says nothing. Walls would seem to hold what
// they do not, and the camera would glide along them.
constexpr double kNormalNoise = 2e-3;

// Points of one edge, and all points of one reference, share their errors: a pose that texture alone holds is
// known less well than the solve believes.
constexpr double kPhotometricTrust = 0.1;

// Texture, or another sensor, that tells a direction to a centimetre holds it where geometry does not.
constexpr double kLeastOtherInformation = 1 / (0.01 * 0.01);

// Robust scale of photometric residuals in grey levels: where it starts, and what it may become.
constexpr double kFirstSigma = 8, kLeastSigma = 2, kLargestSigma = 30;

using PhotometricEquations = exec::NormalEquationsOf<kPhotometricUnknowns>;

// Scales rotation to metres at the lever arm.
Vector6d lever_scale() {
  Vector6d scale;
  scale << Eigen::Vector3d::Constant(1 / kLeverArmM), Eigen::Vector3d::Ones();
  return scale;
}

// What all residuals say together about the pose, and the exposure as far as it depends on the pose.
struct JointEquations {
  Matrix6d A_geometric = Matrix6d::Zero(), A_photometric = Matrix6d::Zero(), A_motion = Matrix6d::Zero();
  Vector6d b = Vector6d::Zero();
  Eigen::Matrix2d A_exposure = Eigen::Matrix2d::Identity();
  Eigen::Matrix<double, 2, 6> A_exposure_pose = Eigen::Matrix<double, 2, 6>::Zero();
  Eigen::Vector2d b_exposure = Eigen::Vector2d::Zero();

  void add(const exec::NormalEquations& geometric, double chi_square) {
    A_geometric = Eigen::Map<const Matrix6d>(&geometric.A[0][0]) / (kGeometricCorrelation * chi_square);
    b += Eigen::Map<const Vector6d>(geometric.b) / (kGeometricCorrelation * chi_square);
  }
  void add(const PhotometricEquations& photometric, double weight) {
    using Matrix8d = Eigen::Matrix<double, kPhotometricUnknowns, kPhotometricUnknowns>;
    using Vector8d = Eigen::Matrix<double, kPhotometricUnknowns, 1>;
    const double scale = weight / kPhotometricCorrelation;
    const Matrix8d H = scale * Eigen::Map<const Matrix8d>(&photometric.A[0][0]);
    const Vector8d g = scale * Eigen::Map<const Vector8d>(photometric.b);
    A_exposure = H.bottomRightCorner<2, 2>() + 1e-9 * Eigen::Matrix2d::Identity();
    A_exposure_pose = H.bottomLeftCorner<2, 6>();
    b_exposure = g.tail<2>();
    // The exposure eliminated (Schur complement).
    const Eigen::Matrix<double, 2, 6> share = A_exposure.inverse() * A_exposure_pose;
    A_photometric = H.topLeftCorner<6, 6>() - A_exposure_pose.transpose() * share;
    b += g.head<6>() - share.transpose() * b_exposure;
  }
  // r = log(T_model_current T_model_motion^-1), whose derivative by the left perturbation is near the
  // identity.
  void add_motion(const Matrix6d& information, const Vector6d& difference) {
    A_motion = information;
    b += information * difference;
  }
  Matrix6d A() const { return A_geometric + A_photometric + A_motion; }
  Eigen::Vector2d exposure_step(const Vector6d& pose_step) const {
    return -A_exposure.inverse() * (b_exposure + A_exposure_pose * pose_step);
  }
};

// Gauss-Newton step; zero along the eigenvectors of the normalised Hessian that nothing constrains.
// `weights`: information of a direction that every geometric residual constrains.
// `held` projects onto the directions that are constrained.
Vector6d solve(const JointEquations& equations, double weights, double min_eigenvalue, Matrix6d* held,
               TrackingQuality* quality) {
  const Vector6d scale = lever_scale();
  const Matrix6d normalised = scale.asDiagonal() * (equations.A() / weights) * scale.asDiagonal();
  const Matrix6d geometric = scale.asDiagonal() * (equations.A_geometric / weights) * scale.asDiagonal();
  const Matrix6d other =
      scale.asDiagonal() * (equations.A_photometric + equations.A_motion) * scale.asDiagonal();
  const Vector6d gradient = scale.asDiagonal() * (equations.b / weights);
  const Eigen::SelfAdjointEigenSolver<Matrix6d> eigen(normalised);
  quality->conditioning = std::max(0.0, eigen.eigenvalues()(0));
  quality->free_directions = 0;
  *held = Matrix6d::Identity();
  Vector6d step = Vector6d::Zero();
  for (int k = 0; k < 6; ++k) {
    const Vector6d direction = eigen.eigenvectors().col(k);
    const double by_geometry = std::max(0.0, direction.dot(geometric * direction) - kNormalNoise),
                 by_others = direction.dot(other * direction);
    if (eigen.eigenvalues()(k) <= 0 ||
        (by_geometry + by_others / weights < min_eigenvalue && by_others < kLeastOtherInformation)) {
      *held -= scale.cwiseInverse().asDiagonal() * direction * direction.transpose() * scale.asDiagonal();
      ++quality->free_directions;
      continue;
    }
    step -= direction * (direction.dot(gradient) / eigen.eigenvalues()(k));
  }
  return scale.asDiagonal() * step;
}

PointToPlane cost(const TrackingConfig& config, const FrameMaps& maps, const FrameMotion& motion,
                  const ModelView& model, int level, const Pose& T_model_current) {
  const SurfaceLevel& surface = maps.levels[static_cast<size_t>(level)];
  return {{surface.depth_view(), surface.normals.data(), surface.camera, to_rigid3f(T_model_current),
           model.camera, model.points.data(), model.normals.data(), motion.depth_rows(surface.camera)},
          static_cast<float>(config.max_distance_m),
          static_cast<float>(std::cos(config.max_normal_angle_deg * kRadPerDegree)),
          static_cast<float>(1 << level),
          static_cast<float>(config.robust_sigmas)};
}

}  // namespace

Vector6d Approach::velocity_at(const Pose& T_odom_camera) const {
  if (dt_s <= 0) return Vector6d::Zero();
  return 0.5 * (velocity + log_se3(T_odom_last.inverse() * T_odom_camera) / dt_s);
}

Tracker::Tracker(const exec::Device& device, const Calibration& calibration, const TrackingConfig& config)
    : device_(device),
      config_(config),
      geometric_workspace_(device, calibration.depth.pinhole().pixel_count()),
      photometric_workspace_(device, calibration.depth.pinhole().half().pixel_count()) {}

TrackResult Tracker::track(const FrameMaps& maps, const ModelView& model,
                           const PhotometricReference* reference, const TrackGuess& guess) {
  constexpr int64_t kFewestPixels = 200;
  const bool has_colour =
      reference && maps.has_colour && !reference->is_empty() && config_.photometric_weight > 0;
  FrameMotion motion;
  const Pose T_model_motion = model.T_odom_camera.inverse() * guess.T_odom_motion;
  const Matrix6d motion_information = transported(guess.motion_information, model.T_odom_camera);
  const bool has_motion = !guess.motion_information.isZero(0);
  TrackResult result;
  result.exposure = guess.exposure;
  Pose T_model_current = model.T_odom_camera.inverse() * guess.T_odom_camera;
  exec::NormalEquations geometric;
  JointEquations joint;
  Matrix6d held = Matrix6d::Identity();
  double sigma = kFirstSigma;
  for (int level = kPyramidLevels - 1; level >= finest_level_; --level) {
    motion = FrameMotion(maps, guess.approach.velocity_at(model.T_odom_camera * T_model_current));
    for (int iteration = 0; iteration < config_.iterations[static_cast<size_t>(level)]; ++iteration) {
      const PointToPlane point_to_plane = cost(config_, maps, motion, model, level, T_model_current);
      const auto started_geometric = exec::start_normal_equations(
          device_, point_to_plane.association.camera.pixel_count(), point_to_plane, geometric_workspace_);
      // Both sums at one pose: a GPU is waited for once.
      std::optional<exec::StartedReduction<kPhotometricUnknowns>> started_photometric;
      if (has_colour && level > 0) {
        const int intensity_level = level - 1;
        const PhotometricResidual residual =
            reference->residual(maps, intensity_level, model.T_odom_camera, T_model_current, result.exposure,
                                static_cast<float>(sigma), motion);
        started_photometric = exec::start_normal_equations(device_, reference->point_count(intensity_level),
                                                           residual, photometric_workspace_);
      }
      geometric = started_geometric.finish();
      if (geometric.count < kFewestPixels) break;
      joint = {};
      // Residuals larger than the noise model predicts scale the information down (reduced chi square).
      const double chi_square =
          std::max(1.0, geometric.weighted_squares / static_cast<double>(geometric.count));
      joint.add(geometric, chi_square);
      if (started_photometric) {
        const PhotometricEquations photometric = started_photometric->finish();
        if (photometric.count >= kFewestPixels) {
          joint.add(photometric, config_.photometric_weight);
          sigma = std::clamp(std::sqrt(photometric.weighted_squares / photometric.weights), kLeastSigma,
                             kLargestSigma);
        }
      }
      if (has_motion)
        joint.add_motion(motion_information, log_se3(T_model_current * T_model_motion.inverse()));
      const double weights = geometric.weights / (kGeometricCorrelation * chi_square);
      const Vector6d step = solve(joint, weights, config_.min_eigenvalue, &held, &result.quality);
      const Eigen::Vector2d exposure_step = joint.exposure_step(step);
      result.exposure.gain += static_cast<float>(exposure_step(0));
      result.exposure.bias += kBiasUnit * static_cast<float>(exposure_step(1));
      T_model_current = orthonormalised(exp_se3(step) * T_model_current);
      if (step.head<3>().norm() < 2e-5 && step.tail<3>().norm() < 4e-5) break;
    }
  }
  result.T_odom_camera = orthonormalised(model.T_odom_camera * T_model_current);
  if (geometric.count < kFewestPixels) {
    result.cause = measured_share(maps) < config_.min_measured_share ? TrackingCause::kNoDepth
                                                                     : TrackingCause::kLowOverlap;
    return result;
  }
  result.quality.residual_m = std::sqrt(geometric.weighted_squares / geometric.weights);
  result.information =
      held * (joint.A_geometric + kPhotometricTrust * joint.A_photometric) * held.transpose();
  judge(maps, motion, model, T_model_current, &result);
  return result;
}

void Tracker::judge(const FrameMaps& maps, const FrameMotion& motion, const ModelView& model,
                    const Pose& T_model_current, TrackResult* result) {
  const JudgePixel functor{cost(config_, maps, motion, model, kJudgedLevel, T_model_current),
                           to_rigid3f(model.T_middle_camera), static_cast<float>(model.half_edge_m)};
  const exec::NormalEquations sums = exec::reduce_normal_equations(
      device_, functor.cost.association.camera.pixel_count(), functor, geometric_workspace_);
  const double measured = sums.weights, associated = sums.weighted_squares, inliers = sums.A[0][0];
  TrackingQuality& quality = result->quality;
  quality.overlap = measured > 0 ? associated / measured : 0;
  quality.inlier_share = associated > 0 ? inliers / associated : 0;

  const double overlap = quality.overlap / config_.min_overlap,
               share = quality.inlier_share / config_.min_inlier_share;
  const double worst = std::min(overlap, share);  // of what is asked
  result->status = worst >= 1     ? TrackingStatus::kGood
                   : worst >= 0.5 ? TrackingStatus::kUncertain
                                  : TrackingStatus::kLost;
  result->cause = worst >= 1        ? TrackingCause::kNone
                  : overlap < share ? TrackingCause::kLowOverlap
                                    : TrackingCause::kFewInliers;
}

double Tracker::measured_share(const FrameMaps& maps, double beyond_m) {
  const SurfaceLevel& surface = maps.levels[kJudgedLevel];
  const std::vector<Vec4f> normals = surface.normals.downloaded();
  const std::vector<float> depth = surface.depth.downloaded();
  const DepthView view{depth.data(), surface.camera.width, surface.camera.height};
  int64_t measured = 0;
  for (int v = 0; v < view.height; ++v) {
    for (int u = 0; u < view.width; ++u) {
      const bool has_normal = normals[static_cast<size_t>(v * view.width + u)].w > 0;
      measured += has_normal && static_cast<double>(view.at(u, v)) > beyond_m;
    }
  }
  return static_cast<double>(measured) / static_cast<double>(normals.size());
}

}  // namespace kt
