// Poses, points and calibration that explain features, odometry and loop closures best.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include "offboard/pose_graph/indexed_graph.h"
#include "offboard/refinement/observation_cost.h"

namespace kt {

/// The camera of each keyframe, and what it has seen.
struct FeatureViews {
  ObservationModel model;
  std::vector<int> node;           ///< of the graph, by keyframe
  std::vector<Vector6d> velocity;  ///< as Keyframe::velocity
};

/// What is sought.
struct BundleState {
  std::vector<Pose> T_world_node;
  CalibrationChange change;
};

struct BundleOptions {
  bool intrinsics = false, delay = false;  ///< which parts of the calibration are free
  /// Of the residuals: above 1 where features are found better than Observation says.
  double scale = 1;
  int max_iterations = 15;
};

/// Residuals beyond so many sigmas count less and less (Cauchy's loss).
inline constexpr double kRobustSigmas = 2;

/// Minimises the pose graph's objective and that of the observations together by Levenberg-Marquardt, points
/// eliminated first (Triggs et al. 1999, "Bundle Adjustment - A Modern Synthesis"), from `state`, which is
/// replaced. `weight`, one per edge. The anchors of the components stay. One thread: the same input gives the
/// same bytes. Throws kt::Error where the solver fails.
void adjust(const IndexedGraph& graph, std::span<const double> weight, const FeatureViews& views,
            std::span<const FeatureTrack> tracks, const BundleOptions& options, BundleState& state);

}  // namespace kt
