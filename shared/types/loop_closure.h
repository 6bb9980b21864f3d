// The measured relative pose between two visits of one place, or why a candidate was rejected.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "shared/core/vec.h"
#include "shared/geometry/se3.h"

namespace kt {

/// What became of a candidate: accepted, or the first test that it failed, in the order of the tests.
enum class LoopVerdict : uint8_t {
  kAccepted = 0,
  kTooFewMatches = 1,    ///< descriptors that agree
  kTooFewInliers = 2,    ///< matches that one rigid motion explains
  kReprojection = 3,     ///< the best motion explains its own inliers badly
  kLittleOverlap = 4,    ///< the surfaces share too little of the view
  kSurfaceMismatch = 5,  ///< what both see of the surface disagrees: in distance, normal or free space
  kUnconstrained = 6,    ///< the surfaces and features leave a direction of motion open
  kWeak = 7,  ///< all tests passed, but odometry all but excludes it: the place may only look the same
};
inline constexpr int kLoopVerdicts = 8;

/// "accepted", "too few matches", "too few inliers", "reprojection", "little overlap", "surface mismatch",
/// "unconstrained" or "weak".
const char* to_string(LoopVerdict verdict);

struct LoopClosure {
  int64_t sequence = 0;      ///< counts the candidates of a log, from 0
  int64_t timestamp_us = 0;  ///< of frame `to`
  int64_t from = 0, to = 0;  ///< sequences of the two frames, from < to
  Pose T_from_to = Pose::Identity();
  Matrix6d information = Matrix6d::Zero();  ///< as StampedPose::information
  LoopVerdict verdict = LoopVerdict::kAccepted;
  bool accepted() const { return verdict == LoopVerdict::kAccepted; }
  // What the tests measured; 0 for those that were not reached.
  float similarity = 0;       ///< of the bags of words, in units of that with the keyframe before; 0 where
                              ///< the poses alone proposed the pair
  int matches = 0;            ///< descriptors that agree
  float reprojection_px = 0;  ///< root mean square of the inliers
  float overlap = 0;          ///< share of the smaller view that both see
  float surface_rms_m = 0;    ///< between the two surfaces, along the normals
  std::vector<Vec3f> p_from, p_to;  ///< inlier points in either camera (m), pairwise
};

}  // namespace kt
