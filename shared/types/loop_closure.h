// The measured relative pose between two visits of one place, or why a candidate was rejected.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "shared/core/vec.h"
#include "shared/geometry/se3.h"

namespace kt {

struct LoopClosure {
  int64_t sequence = 0;      ///< counts the candidates of a log, from 0
  int64_t timestamp_us = 0;  ///< of frame `to`
  int64_t from = 0, to = 0;  ///< sequences of the two frames, from < to
  Pose T_from_to = Pose::Identity();
  Matrix6d information = Matrix6d::Zero();  ///< as StampedPose::information
  bool accepted = false;
  std::string reason;               ///< empty where accepted, else the test that failed
  std::vector<Vec3f> p_from, p_to;  ///< inlier points in either camera (m), pairwise
};

}  // namespace kt
