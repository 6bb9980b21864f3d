// Gauss-Newton over three angles and the exposure.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/tracking/rotation_aligner.h"

#include <Eigen/Cholesky>
#include <algorithm>

#include "shared/exec/for_each.h"

namespace kt {
namespace {

constexpr int kCoarsest = kIntensityLevels - 1;
constexpr int kMaxIterations = 12;
constexpr float kRotationCauchySigmas = 2.5f;
constexpr double kSigma = 10;  // grey levels
// An overlap this small says nothing.
constexpr double kLeastShare = 0.3;

using Equations = exec::NormalEquationsOf<kPhotometricUnknowns>;
using Vector5d = Eigen::Matrix<double, 5, 1>;

// Over [omega; gain; bias].
Vector5d solve(const Equations& equations) {
  constexpr int kUnknowns[5] = {0, 1, 2, kGainUnknown, kBiasUnknown};
  Eigen::Matrix<double, 5, 5> A;
  Vector5d b;
  for (int i = 0; i < 5; ++i) {
    for (int j = 0; j < 5; ++j) A(i, j) = equations.A[kUnknowns[i]][kUnknowns[j]];
    b(i) = equations.b[kUnknowns[i]];
  }
  A.diagonal() *= 1 + 1e-6;
  return -A.ldlt().solve(b);
}

// Mean robust loss of the points in sight, in squared sigmas.
double mean_loss(const Equations& equations) {
  return equations.weighted_squares / std::max(1.0, static_cast<double>(equations.count));
}

}  // namespace

RotationAligner::RotationAligner(const exec::Device& device, const Calibration& calibration)
    : device_(device),
      T_colour_depth_(calibration.T_colour_depth),
      last_(device, SamplePhotometricPoint::count(calibration.depth.pinhole().half().half())),
      workspace_(device, last_.size()) {}

void RotationAligner::remember(const FrameMaps& maps) {
  has_last_ = maps.has_colour;
  last_us_ = maps.timestamp_us;
  last_colour_us_ = maps.colour_timestamp_us;
  if (!has_last_) return;
  const SurfaceLevel& surface = maps.levels[kPyramidLevels - 1];
  const IntensityLevel& intensity = maps.intensity.level(kCoarsest);
  exec::for_each(device_, last_.size(),
                 SamplePhotometricPoint{surface.depth_view(), surface.camera, to_rigid3f(T_colour_depth_),
                                        intensity.view(), intensity.camera, last_.data()});
}

Pose RotationAligner::align(const FrameMaps& maps, const Pose& T_guess) {
  // The images' stamps lie apart otherwise than those of the depth images: what moved between them is
  // scaled.
  const auto interval_us = static_cast<double>(maps.timestamp_us - last_us_),
             colour_interval_us = static_cast<double>(maps.colour_timestamp_us - last_colour_us_);
  if (!has_last_ || !maps.has_colour || interval_us <= 0 || colour_interval_us <= 0) return T_guess;
  const double scale = colour_interval_us / interval_us;
  if (scale < 0.5 || scale > 2) return T_guess;
  const IntensityLevel& intensity = maps.intensity.level(kCoarsest);
  const int64_t points = last_.size();
  // From the last camera to where the current one is, turned as the last one.
  const Rigid3f T_moved_last = to_rigid3f(Pose(Eigen::Translation3d(-scale * T_guess.translation())));
  Eigen::Matrix3d R_last_current = exp_so3(scale * log_so3(T_guess.linear()));
  Exposure exposure;
  double first_loss = 0, best_cost = 0;
  Eigen::Matrix3d best = R_last_current;
  for (int iteration = 0; iteration <= kMaxIterations; ++iteration) {
    const PhotometricResidual residual{
        last_.data(),
        T_moved_last,
        to_rigid3f(T_colour_depth_ * Pose(R_last_current.transpose())),
        {intensity.view(), intensity.camera, exposure, static_cast<float>(kSigma), kRotationCauchySigmas}};
    const Equations equations = exec::reduce_normal_equations(device_, points, residual, workspace_);
    const double share = static_cast<double>(equations.count) / static_cast<double>(points);
    if (share < kLeastShare) break;
    if (iteration == 0) first_loss = best_cost = mean_loss(equations);
    // What went out of sight is no better known than at the guess.
    const double cost = share * mean_loss(equations) + (1 - share) * first_loss;
    if (cost < best_cost) best_cost = cost, best = R_last_current;
    if (iteration == kMaxIterations) break;
    const Vector5d step = solve(equations);
    R_last_current = exp_so3(step.head<3>()) * R_last_current;
    exposure.gain += static_cast<float>(step(3));
    exposure.bias += static_cast<float>(step(4)) * kBiasUnit;
    if (step.head<3>().norm() < 1e-4) break;
  }
  if (!(best_cost < first_loss)) return T_guess;
  Pose T_last_current = T_guess;
  T_last_current.linear() = exp_so3(log_so3(best) / scale);
  return T_last_current;
}

}  // namespace kt
