// Whether loops agree with odometry and with each other, and how far the covariances of both can be trusted.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "offboard/pose_graph/indexed_graph.h"
#include "offboard/pose_graph/odometry_forest.h"

namespace kt {

/// Quantiles of chi-square with 6 degrees of freedom.
inline constexpr double kChiSquare25 = 3.455, kChiSquare50 = 5.348, kChiSquare99 = 16.812,
                        kChiSquare999 = 22.458;
/// Scales are medians and quartiles, as if this many more loops had found the given covariances right.
inline constexpr int kScalePriorLoops = 3;
inline constexpr double kOdometryScaleMin = 0.1, kOdometryScaleMax = 1000;
inline constexpr double kLoopScaleMin = 0.3, kLoopScaleMax = 10;

/// For OdometryForest: 1 for each edge that is no loop.
std::vector<double> odometry_only(const IndexedGraph& graph);

/// Of the way i -> j by `a`, back by `b` and by odometry at both ends: how far from none it is, in sigmas
/// squared (the pairwise consistency of Mangelson et al. 2018, eq. 8). Both loops must lead between the same
/// two trees. `loop_share`, where given, becomes the part that the two loops have in the covariance, of 6.
double cycle_squared_sigmas(const OdometryForest& odometry, const IndexedEdge& a, const IndexedEdge& b,
                            double* loop_share = nullptr);

/// The factor on odometry's covariance at which the median loop within a tree lies as far from it as a
/// chi-square has its median: right while less than half of the loops are false. Drift that accumulates
/// systematically counts as such a factor too. Only loops that odometry outweighs tell, by what it says of
/// itself or would at that factor: the largest such factor is taken.
double measured_odometry_scale(const IndexedGraph& graph, const OdometryForest& odometry);

/// The factor on the loops' covariance at which the best quarter of neighbours among them agree as they
/// should, for most may have a false loop in them. Below 1 only as far as the better half says so too: false
/// loops of places that look alike agree better than true ones.
double measured_loop_scale(const IndexedGraph& graph, const OdometryForest& odometry);

}  // namespace kt
