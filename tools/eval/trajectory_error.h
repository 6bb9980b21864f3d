// Absolute and relative trajectory error as the TUM benchmark's tools define them (Sturm et al. 2012).
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "shared/io/stamp_association.h"
#include "shared/types/stamped_pose.h"
#include "tools/eval/statistics.h"

namespace kt {

/// How far an estimated position lies from the true one after the best rigid alignment.
struct AbsoluteTrajectoryError {
  struct Sample {
    int64_t timestamp_us = 0;  ///< of the estimate
    Eigen::Vector3d p_groundtruth,
        p_estimate;  ///< camera centres in the ground truth's frame (m), estimate aligned
    double error_m = 0;
  };
  std::vector<Sample> samples;  ///< one per pair, in order of time
  Statistics translation_m;
  Pose T_groundtruth_estimate = Pose::Identity();  ///< the alignment, SE(3): no scale
  double estimate_paired_share = 0;                ///< of the estimate's poses
  double groundtruth_covered_share =
      0;  ///< of the ground truth's poses, those with an estimate in the window
};

/// Pairs the stamps as associate_stamps does, aligns with Horn's closed form. Throws kt::Error where fewer
/// than three poses pair.
AbsoluteTrajectoryError absolute_trajectory_error(const Trajectory& groundtruth, const Trajectory& estimate,
                                                  int64_t max_difference_us = kMaxStampDifference_us);

/// The rigid T_groundtruth_estimate that fits whole poses, not centres alone: of each pose, the six points 2
/// m along its axes. A short, straight or turning path determines it as well as a long one, and an
/// orientation that is off weighs as it does on the surface that such a camera maps. Throws kt::Error where
/// no poses pair.
Pose align_poses(const Trajectory& groundtruth, const Trajectory& estimate,
                 int64_t max_difference_us = kMaxStampDifference_us);

enum class DeltaUnit { kSeconds, kMetres, kFrames };

/// How far the motion over one span is off.
struct RelativeError {
  size_t from = 0, to = 0;  ///< indices into the estimate
  Pose E;                   ///< on the left: T_from_to of the estimate = E * T_from_to of the truth
};

/// Compares the estimate's motion over `delta` (time, path length or poses), from every pose on, with that of
/// the closest ground-truth poses. Spans begin in order of time.
std::vector<RelativeError> relative_errors(const Trajectory& groundtruth, const Trajectory& estimate,
                                           double delta = 1, DeltaUnit unit = DeltaUnit::kSeconds);

/// Summary of relative_errors.
struct RelativePoseError {
  Statistics translation_m, rotation_deg;
  /// Mean error of each axis of the camera that a span begins at: what does not average out is a bias.
  Eigen::Vector3d mean_translation_m, mean_rotation_rad;
  int64_t pairs = 0;
};

/// Every pair counts: the benchmark's tool draws 10000 at random where there are more. Nothing where fewer
/// than two pairs are left, as where the estimate is shorter than `delta`.
std::optional<RelativePoseError> relative_pose_error(const Trajectory& groundtruth,
                                                     const Trajectory& estimate, double delta = 1,
                                                     DeltaUnit unit = DeltaUnit::kSeconds);

}  // namespace kt
