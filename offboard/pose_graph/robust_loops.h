// Which loop closures to believe: against odometry, between segments, and all together.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "offboard/pose_graph/indexed_graph.h"

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

/// Quantiles of chi-square with 6 degrees of freedom: 50 %, 99 %, 99.9 %.
inline constexpr double kChiSquareMedian = 5.348, kChiSquare99 = 16.812, kChiSquare999 = 22.458;
/// How many times too large the information of a true loop may be: thresholds are that much wider.
inline constexpr double kInformationDoubt = 10;
/// Loops that agree on how two segments stand to each other, below which the segments stay apart.
inline constexpr int kLoopsToJoin = 2;
/// The scale of odometry's covariance is that at which the median loop is where a chi-square has its median, as
/// if this many more loops had found it right, and within these bounds.
inline constexpr int kScalePriorLoops = 3;
inline constexpr double kScaleMin = 0.1, kScaleMax = 100;

struct LoopDecision {
  std::vector<double> weight;        ///< per edge: 1, or 0 for a loop that is not accepted
  std::vector<LoopOutcome> outcome;  ///< per edge; kAccepted for those that are no loops
  double odometry_scale = 1;         ///< of its covariance, as measured by the loops
  int solves = 0;                    ///< least squares problems that it took
};

/// 1. Odometry's covariance is scaled by what the loops within segments measure (median, hence right while less
///    than half of them are false). A segment is what odometry edges hold together.
/// 2. Segments are joined where kLoopsToJoin loops agree pairwise (the consistency of Mangelson et al. 2018) with
///    one that most of the others agree with; again with what has been joined, until nothing changes.
/// 3. A loop that scaled odometry all but excludes is rejected.
/// 4. Graduated non-convexity with truncated least squares over those left (Yang et al. 2020, "Graduated
///    Non-Convexity for Robust Spatial Perception"), odometry at its scaled weight throughout.
/// `T_world_node` begins at a chordal start from the loops that are left after 3 and ends where 4 ends.
LoopDecision decide_loops(const IndexedGraph& graph, std::vector<Pose>& T_world_node);

}  // namespace kt
