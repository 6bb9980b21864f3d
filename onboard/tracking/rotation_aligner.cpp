// Gauss-Newton over three angles and the exposure.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/tracking/rotation_aligner.h"

#include <Eigen/Cholesky>
#include <algorithm>

#include "onboard/tracking/frame_view_kernel.h"
#include "shared/exec/for_each.h"

namespace kt {
namespace {

constexpr int kCoarsest = kIntensityLevels - 1;
constexpr int kMaxIterations = 12;
constexpr float kRotationCauchySigmas = 2.5f;
constexpr double kSigma = 10;  // grey levels
// An overlap this small says nothing.
constexpr double kLeastShare = 0.3;

Mat3f to_mat3f(const Eigen::Matrix3d& R) {
  Mat3f m;
  for (int i = 0; i < 9; ++i) m.m[i] = static_cast<float>(R(i / 3, i % 3));
  return m;
}

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

// Mean robust loss in squared sigmas; what is out of sight counts as an
// outlier.
double cost(const Equations& equations, int64_t pixels) {
  const auto count = static_cast<double>(equations.count);
  const double seen = equations.weighted_squares / std::max(1.0, count);
  const double share = count / static_cast<double>(pixels);
  return share * seen + (1 - share) * kRotationCauchySigmas * kRotationCauchySigmas;
}

}  // namespace

RotationAligner::RotationAligner(const exec::Device& device, const Calibration& calibration)
    : device_(device),
      R_colour_depth_(calibration.T_colour_depth.linear()),
      workspace_(device, calibration.colour.pinhole().pixel_count() >> (2 * kIntensityLevels)) {
  last_ = {device, calibration.colour.pinhole().pixel_count() >> (2 * kIntensityLevels)};
}

void RotationAligner::remember(const FrameMaps& maps) {
  has_last_ = maps.has_colour;
  last_us_ = maps.timestamp_us;
  last_colour_us_ = maps.colour_timestamp_us;
  if (!has_last_) return;
  const IntensityLevel& intensity = maps.intensity.level(kCoarsest);
  exec::for_each(device_, intensity.camera.pixel_count(), CopyFloats{intensity.levels.data(), last_.data()});
}

Eigen::Matrix3d RotationAligner::align(const FrameMaps& maps, const Eigen::Matrix3d& R_guess) {
  // The images' stamps lie apart otherwise than those of the depth images: what turned between them is
  // scaled.
  const auto interval_us = static_cast<double>(maps.timestamp_us - last_us_),
             colour_interval_us = static_cast<double>(maps.colour_timestamp_us - last_colour_us_);
  if (!has_last_ || !maps.has_colour || interval_us <= 0 || colour_interval_us <= 0) return R_guess;
  const double scale = colour_interval_us / interval_us;
  if (scale < 0.5 || scale > 2) return R_guess;
  const IntensityLevel& intensity = maps.intensity.level(kCoarsest);
  const int64_t pixels = intensity.camera.pixel_count();
  Eigen::Matrix3d R_last_current =
      R_colour_depth_ * exp_so3(scale * log_so3(R_guess)) * R_colour_depth_.transpose();
  Exposure exposure;
  double first_cost = 0;
  Eigen::Matrix3d best = R_last_current;
  double best_cost = 0;
  for (int iteration = 0; iteration <= kMaxIterations; ++iteration) {
    const RotationResidual residual{
        {last_.data(), intensity.camera.width, intensity.camera.height},
        to_mat3f(R_last_current.transpose()),
        {intensity.view(), intensity.camera, exposure, static_cast<float>(kSigma), kRotationCauchySigmas}};
    const Equations equations = exec::reduce_normal_equations(device_, pixels, residual, workspace_);
    if (static_cast<double>(equations.count) < kLeastShare * static_cast<double>(pixels)) break;
    const double now = cost(equations, pixels);
    if (iteration == 0) first_cost = best_cost = now;
    if (now < best_cost) best_cost = now, best = R_last_current;
    if (iteration == kMaxIterations) break;
    const Vector5d step = solve(equations);
    R_last_current = exp_so3(step.head<3>()) * R_last_current;
    exposure.gain += static_cast<float>(step(3));
    exposure.bias += static_cast<float>(step(4)) * kBiasUnit;
    if (step.head<3>().norm() < 1e-4) break;
  }
  if (!(best_cost < first_cost)) return R_guess;
  return exp_so3(log_so3(R_colour_depth_.transpose() * best * R_colour_depth_) / scale);
}

}  // namespace kt
