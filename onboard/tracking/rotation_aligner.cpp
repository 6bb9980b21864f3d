// Gauss-Newton over three angles and the exposure.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/tracking/rotation_aligner.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <vector>

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

// Gauss-Newton step over some of the unknowns.
template <size_t kCount>
Eigen::Vector<double, int{kCount}> solve(const Equations& equations,
                                         const std::array<int, kCount>& unknowns) {
  Eigen::Matrix<double, int{kCount}, int{kCount}> A;
  Eigen::Vector<double, int{kCount}> b;
  for (size_t i = 0; i < kCount; ++i) {
    for (size_t j = 0; j < kCount; ++j)
      A(static_cast<int>(i), static_cast<int>(j)) = equations.A[unknowns[i]][unknowns[j]];
    b(static_cast<int>(i)) = equations.b[unknowns[i]];
  }
  A.diagonal() *= 1 + 1e-6;
  return -A.ldlt().solve(b);
}

void step_exposure(const Eigen::Vector2d& step, Exposure* exposure) {
  exposure->gain += static_cast<float>(step(0));
  exposure->bias += static_cast<float>(step(1)) * kBiasUnit;
}

// Mean robust loss of the points in sight, in squared sigmas.
double mean_loss(const Equations& equations) {
  return equations.weighted_squares / std::max(1.0, static_cast<double>(equations.count));
}

// How many points an image without holes shows of a scene far away.
int64_t visible_points(const Calibration& calibration, const PinholeParams& depth_camera) {
  const PinholeParams colour = calibration.colour.pinhole().at_level(kIntensityLevels);
  const std::vector<float> no_depth(
      static_cast<size_t>(DepthView::padded_size(depth_camera.width, depth_camera.height))),
      black(static_cast<size_t>(colour.pixel_count()));
  std::vector<Vec4f> points(static_cast<size_t>(SamplePhotometricPoint::count(depth_camera)));
  const SamplePhotometricPoint sample{{no_depth.data(), depth_camera.width, depth_camera.height},
                                      depth_camera,
                                      to_rigid3f(calibration.T_colour_depth),
                                      {black.data(), colour.width, colour.height},
                                      colour,
                                      points.data()};
  for (int64_t i = 0; i < std::ssize(points); ++i) sample(i);
  return std::ranges::count_if(points, [](const Vec4f& point) { return point.z > 0; });
}

}  // namespace

RotationAligner::RotationAligner(const exec::Device& device, const Calibration& calibration)
    : device_(device),
      T_colour_depth_(calibration.T_colour_depth),
      depth_camera_(calibration.depth.pinhole().at_level(kPyramidLevels - 1)),
      visible_points_(visible_points(calibration, depth_camera_)),
      last_(device, SamplePhotometricPoint::count(depth_camera_)),
      workspace_(device, last_.size()) {}

void RotationAligner::remember(const FrameMaps& maps) {
  has_last_ = maps.has_colour;
  last_us_ = maps.timestamp_us;
  last_colour_us_ = maps.colour_timestamp_us;
  if (!has_last_) return;
  const SurfaceLevel& surface = maps.levels[kPyramidLevels - 1];
  const IntensityLevel& intensity = maps.intensity.level(kCoarsest);
  KT_CHECK(surface.camera.width == depth_camera_.width && surface.camera.height == depth_camera_.height);
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
  // From the last camera to where the current one is, turned as the last one.
  const Rigid3f T_moved_last = to_rigid3f(Pose(Eigen::Translation3d(-scale * T_guess.translation())));
  Eigen::Matrix3d R_last_current = exp_so3(scale * log_so3(T_guess.linear()));
  Exposure exposure;
  const auto compared = [&] {
    const PhotometricResidual residual{
        last_.data(),
        T_moved_last,
        to_rigid3f(T_colour_depth_ * Pose(R_last_current.transpose())),
        {intensity.view(), intensity.camera, exposure, static_cast<float>(kSigma), kRotationCauchySigmas}};
    return exec::reduce_normal_equations(device_, last_.size(), residual, workspace_);
  };
  // Without a change of exposure first, any turn would explain it better than none.
  step_exposure(solve(compared(), std::array{kGainUnknown, kBiasUnknown}), &exposure);
  double first_loss = 0, best_cost = 0;
  Eigen::Matrix3d best = R_last_current;
  for (int iteration = 0; iteration <= kMaxIterations; ++iteration) {
    const Equations equations = compared();
    const double share = static_cast<double>(equations.count) / static_cast<double>(visible_points_);
    if (share < kLeastShare) break;
    if (iteration == 0) first_loss = best_cost = mean_loss(equations);
    // What went out of sight is no better known than at the guess.
    const double cost = share * mean_loss(equations) + (1 - share) * first_loss;
    if (cost < best_cost) best_cost = cost, best = R_last_current;
    if (iteration == kMaxIterations) break;
    const auto step = solve(equations, std::array{0, 1, 2, kGainUnknown, kBiasUnknown});
    R_last_current = exp_so3(step.head<3>()) * R_last_current;
    step_exposure(step.tail<2>(), &exposure);
    if (step.head<3>().norm() < 1e-4) break;
  }
  if (!(best_cost < first_loss)) return T_guess;
  Pose T_last_current = T_guess;
  T_last_current.linear() = exp_so3(log_so3(best) / scale);
  return T_last_current;
}

}  // namespace kt
