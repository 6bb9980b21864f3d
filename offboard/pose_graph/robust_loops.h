// Which loop closures to believe: against odometry, between segments, and all together.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "offboard/pose_graph/loop_consistency.h"

namespace kt {

enum class LoopOutcome {
  kAccepted,
  kUnconfirmed,      ///< would join two segments, but too few other loops agree
  kAgainstOdometry,  ///< odometry between its ends all but excludes it
  kInconsistent,     ///< disagrees with what odometry and the other loops say together
  kUninformative,    ///< came without information
};
/// "accepted", "unconfirmed", "against odometry", "inconsistent" or "uninformative".
const char* to_string(LoopOutcome outcome);

/// Loops that agree on how two segments stand to each other, below which the segments stay apart.
inline constexpr int kLoopsToJoin = 2;
/// A loop, or the cycle of two of them, is rejected beyond this: twice what one true loop of 1000 exceeds
/// where the scaled covariances are right. Drift is no white noise, so they never quite are.
inline constexpr double kGate = 2 * kChiSquare999;
/// Truncation of least squares.
inline constexpr double kTruncation = kChiSquare99;
/// Loops both of whose ends lie within this movement of each other (m + rad, by odometry) have one vote
/// together.
inline constexpr double kVoteReach = 1;

struct LoopDecision {
  std::vector<double> weight;        ///< per edge: 1, or 0 for a loop that is not accepted
  std::vector<LoopOutcome> outcome;  ///< per edge; kAccepted for those that are no loops
  double odometry_scale = 1;         ///< of its covariance, as the loops measure it
  double loop_scale = 1;             ///< of their covariance, as neighbours among them measure it
  int solves = 0;                    ///< least squares problems that it took
};

/// 1. The covariances of odometry and loops are scaled by what the loops say of them (loop_consistency.h),
///    that of odometry by loops between segments too; given ones may be off by a factor of ten. The scales
///    serve the decision only.
/// 2. Segments, what odometry edges hold together, are joined where kLoopsToJoin loops agree pairwise with
///    the one that most agree with; again with what has been joined, until nothing changes.
/// 3. A loop that scaled odometry all but excludes is rejected.
/// 4. Graduated non-convexity with truncated least squares over those left, from a chordal start (Yang et al.
///    2020, "Graduated Non-Convexity for Robust Spatial Perception"). Neighbouring loops share one vote;
///    odometry is never truncated.
LoopDecision decide_loops(const IndexedGraph& given);

}  // namespace kt
