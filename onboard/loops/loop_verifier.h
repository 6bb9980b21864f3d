// Proves or rejects that two keyframes show one place, and measures where they stand to each other.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "onboard/loops/feature_extractor.h"
#include "onboard/loops/surface_aligner.h"
#include "onboard/tracking/feature_aligner.h"
#include "shared/types/calibration.h"
#include "shared/types/keyframe.h"
#include "shared/types/loop_closure.h"

namespace kt {

struct VerificationConfig {
  int min_matches = 20;               ///< sigma of the paper: descriptors that agree
  double max_descriptor_ratio = 0.8;  ///< between the nearest and the second nearest descriptor
  double min_inlier_share = 0.35;  ///< mu of the paper: of the matches, those that one rigid motion explains
  int min_inliers = 15;            ///< and so many of them
  double max_surface_error_m2 = 4e-4;  ///< phi of the paper: mean square distance between the surfaces
  double min_overlap = 0.25;           ///< of either view, what the other sees too
  double max_conflict = 0.1;           ///< of what both see, what contradicts
};

/// A keyframe with the vocabulary's nodes of its descriptors.
struct Place {
  Keyframe keyframe;
  std::vector<int32_t> nodes;
};

/// Needs nothing but the keyframes, so that a log can be searched again.
class LoopVerifier {
 public:
  LoopVerifier(const Calibration& calibration, const DescriptorKind& kind, const VerificationConfig& config);

  /// Compares the places in the paper's order (sec. III-A.4): descriptors, 3-point RANSAC, reprojection,
  /// surfaces. The verdict is the first test that fails; `from` must be of an earlier frame than `to`.
  LoopClosure verify(const Place& from, const Place& to);

 private:
  VerificationConfig config_;
  DescriptorKind kind_;
  FeatureCamera camera_;
  PinholeParams depth_camera_;  // of a keyframe's depth
  double readout_s_;
  exec::Device cpu_;
  SurfaceAligner surfaces_;
};

}  // namespace kt
