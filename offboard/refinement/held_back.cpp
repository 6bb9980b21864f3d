// Each track by itself: its point alone is fitted.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/refinement/held_back.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "shared/core/check.h"

namespace kt {

LocatedPoint locate(const FeatureViews& views, const FeatureTrack& track, const BundleState& state,
                    double scale) {
  constexpr int kSteps = 5;
  const auto pose_of = [&](const Observation& seen) -> const Pose& {
    return state.T_world_node[static_cast<size_t>(views.node[static_cast<size_t>(seen.keyframe)])];
  };
  LocatedPoint result;
  for (const Observation& seen : track)
    result.p_world += pose_of(seen) * seen.p_camera / static_cast<double>(track.size());
  for (int step = 0; step <= kSteps; ++step) {
    Eigen::Matrix3d A = Eigen::Matrix3d::Zero();
    Eigen::Vector3d b = Eigen::Vector3d::Zero();
    result.squares = result.loss = 0;
    for (const Observation& seen : track) {
      const Pose T_camera_world = pose_of(seen).inverse(Eigen::Isometry);
      Eigen::Vector3d r;
      Eigen::Matrix3d by_point;
      Eigen::Matrix<double, 3, 4> by_change;
      if (!views.model.residual(seen, T_camera_world * result.p_world,
                                views.velocity[static_cast<size_t>(seen.keyframe)], state.change, &r,
                                &by_point, &by_change))
        continue;
      constexpr double kCauchy = kRobustSigmas * kRobustSigmas;
      const double square = scale * scale * r.squaredNorm(), weight = 1 / (1 + square / kCauchy);
      const Eigen::Matrix3d J = by_point * T_camera_world.linear();
      A += weight * J.transpose() * J;
      b += weight * J.transpose() * r;
      result.squares += square;
      result.loss += kCauchy * std::log1p(square / kCauchy);
    }
    if (step < kSteps) result.p_world -= A.ldlt().solve(b);
  }
  return result;
}

std::vector<double> losses(const FeatureViews& views, std::span<const FeatureTrack> tracks,
                           const BundleState& state, double scale) {
  std::vector<double> result;
  for (const FeatureTrack& track : tracks)
    result.push_back(locate(views, track, state, scale).loss / static_cast<double>(3 * (track.size() - 1)));
  return result;
}

double measured_scale(const FeatureViews& views, std::span<const FeatureTrack> tracks,
                      const BundleState& state) {
  constexpr double kMedian = 0.79;  // of chi-square by degree of freedom, of three
  if (tracks.empty()) return 1;
  std::vector<double> squares;
  for (const FeatureTrack& track : tracks)
    squares.push_back(locate(views, track, state).squares / static_cast<double>(3 * (track.size() - 1)));
  const auto middle = squares.begin() + static_cast<ptrdiff_t>(squares.size() / 2);
  std::nth_element(squares.begin(), middle, squares.end());
  return std::sqrt(kMedian / std::max(*middle, 1e-6));
}

Comparison compare(std::span<const double> before, std::span<const double> after) {
  KT_CHECK(before.size() == after.size());
  Comparison result;
  if (before.empty()) return result;
  const auto count = static_cast<double>(before.size());
  double gain = 0, squares = 0;
  for (size_t i = 0; i < before.size(); ++i) {
    result.before += before[i] / count;
    result.after += after[i] / count;
    gain += (before[i] - after[i]) / count;
  }
  for (size_t i = 0; i < before.size(); ++i) squares += std::pow(before[i] - after[i] - gain, 2);
  const double error = std::sqrt(squares / std::max(1.0, count - 1) / count);
  result.sigmas = error > 0 ? gain / error : 0;
  return result;
}

}  // namespace kt
