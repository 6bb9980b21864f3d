// How well tracks that nothing was fitted to agree with poses and calibration.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include "offboard/refinement/bundle_adjustment.h"

namespace kt {

/// The point of a track that explains its observations best, and how well it does.
struct LocatedPoint {
  Eigen::Vector3d p_world = Eigen::Vector3d::Zero();
  double squares = 0;  ///< sum of the residuals' squares, in sigmas
  double loss = 0;     ///< the same with large ones counting less (kRobustSigmas)
};

/// By Gauss-Newton from the mean of the measured points.
LocatedPoint locate(const FeatureViews& views, const FeatureTrack& track, const BundleState& state,
                    double scale = 1);

/// By track, the loss by degree of freedom (3 for each observation, less 3 for the point).
std::vector<double> losses(const FeatureViews& views, std::span<const FeatureTrack> tracks,
                           const BundleState& state, double scale);

/// The factor on the residuals that makes their median what it is of normal errors of variance 1.
double measured_scale(const FeatureViews& views, std::span<const FeatureTrack> tracks,
                      const BundleState& state);

/// Mean of `before`, of `after`, and how many standard errors of their mean difference lie between.
struct Comparison {
  double before = 0, after = 0, sigmas = 0;
  /// By more than 3 standard errors and by more than 1 %: tracks share cameras, so that the standard error
  /// alone is too small.
  bool is_better() const { return sigmas > 3 && after < 0.99 * before; }
};
Comparison compare(std::span<const double> before, std::span<const double> after);

}  // namespace kt
