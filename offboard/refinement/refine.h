// Refines the poses of a mission, and its calibration, by the features of its keyframes.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "offboard/pose_graph/mission_graph.h"
#include "offboard/pose_graph/optimise.h"
#include "offboard/refinement/held_back.h"
#include "shared/types/session.h"

namespace kt {

/// One thing that was let free, and what the held-back tracks said to it.
struct RefinementStep {
  std::string name;          ///< "poses", "intrinsics" or "colour delay"
  CalibrationChange change;  ///< found
  Comparison held_back;      ///< loss by degree of freedom, without it and with it
  bool is_kept = false;
};

struct Refinement {
  int64_t tracks = 0, tracks_held_back = 0, observations = 0;
  double scale = 1;  ///< as BundleOptions::scale
  std::vector<RefinementStep> steps;
  std::vector<Pose> T_world_camera;  ///< by pose; empty where they stay as they are
  CalibrationChange change;          ///< of what was kept
};

/// Bundle adjustment of all poses over features with depth, beside odometry and the closures that `solution`
/// believes in. Poses, then intrinsics, then the delay of the colour image are let free, each kept only where
/// it lowers the error of tracks that were held back, a quarter of all (Comparison::is_better). The result
/// does not depend on the number of threads. A mission without keyframes or with hardly any track stays as it
/// is.
Refinement refine(const Session& session, const MissionGraph& measured, const OptimisedGraph& solution,
                  int threads, const std::function<void(double share)>& progress);

/// The calibration with a change made to it.
Calibration changed(const Calibration& calibration, const CalibrationChange& change);

}  // namespace kt
