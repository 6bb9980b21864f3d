// Cycles of two loops and odometry, and the scales of both covariances that follow from them.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/pose_graph/loop_consistency.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <utility>

namespace kt {
namespace {

Matrix6d covariance(const IndexedEdge& edge) { return edge.information.llt().solve(Matrix6d::Identity()); }

/// Such that `share` of the values lie below it.
double quantile(std::vector<double> values, double share) {
  const auto rank = values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size()));
  std::nth_element(values.begin(), rank, values.end());
  return *rank;
}

}  // namespace

std::vector<double> odometry_only(const IndexedGraph& graph) {
  std::vector<double> result;
  for (const IndexedEdge& edge : graph.edges) result.push_back(edge.is_loop ? 0 : 1);
  return result;
}

double measured_odometry_scale(const IndexedGraph& graph, const OdometryForest& odometry) {
  // Of a loop, in axes in which its own covariance is one and that of odometry diagonal.
  struct Sample {
    Vector6d error, odometry;
  };
  std::vector<Sample> samples;
  for (const IndexedEdge& edge : graph.edges) {
    if (!edge.is_loop || !edge.is_informative() || odometry.tree(edge.from) != odometry.tree(edge.to))
      continue;
    const OdometryForest::Motion motion = odometry.between(edge.from, edge.to);
    const Vector6d error = log_se3(motion.T_from_to * edge.T_from_to.inverse(Eigen::Isometry));
    const Matrix6d whitener = Matrix6d(edge.information.llt().matrixL()).transpose();
    const Eigen::SelfAdjointEigenSolver<Matrix6d> axes(whitener * motion.covariance * whitener.transpose());
    samples.push_back({axes.eigenvectors().transpose() * whitener * error, axes.eigenvalues().cwiseMax(0.0)});
  }
  const auto is_too_small = [&samples](double scale) {
    std::vector<double> squares(kScalePriorLoops, kChiSquare50 / scale);
    for (const Sample& sample : samples) {
      // Short loops, whose own noise hides that of odometry, do not tell.
      const Eigen::Array<double, 6, 1> most = std::max(scale, 1.0) * sample.odometry.array();
      if ((most / (most + 1)).sum() < 3) continue;
      squares.push_back((sample.error.array().square() / (scale * sample.odometry.array() + 1)).sum());
    }
    return quantile(std::move(squares), 0.5) > kChiSquare50;
  };
  // From above: to odometry that believes too much of itself all loops seem short.
  constexpr double kStep = 1.1;
  double high = kOdometryScaleMax;
  while (high > kOdometryScaleMin && !is_too_small(high / kStep)) high /= kStep;
  double low = std::log(high / kStep);
  high = std::log(high);
  for (int step = 0; step < 12; ++step) {
    const double middle = (low + high) / 2;
    (is_too_small(std::exp(middle)) ? low : high) = middle;
  }
  return std::max(std::exp((low + high) / 2), kOdometryScaleMin);
}

double cycle_squared_sigmas(const OdometryForest& odometry, const IndexedEdge& a, const IndexedEdge& b,
                            double* loop_share) {
  const bool is_same_way = odometry.tree(a.from) == odometry.tree(b.from);
  const OdometryForest::Motion start = odometry.between(a.from, is_same_way ? b.from : b.to);
  const OdometryForest::Motion end = odometry.between(is_same_way ? b.to : b.from, a.to);
  // What the detour over b says of a, T_i_j = start * b * end, with its covariance in the frame of i.
  const Pose T_b = is_same_way ? b.T_from_to : b.T_from_to.inverse(Eigen::Isometry);
  const Pose before_end = start.T_from_to * T_b;
  const Matrix6d to_i_of_b = adjoint(is_same_way ? start.T_from_to : before_end);
  const Matrix6d to_i_of_end = adjoint(before_end);
  const Matrix6d by_b = to_i_of_b * covariance(b) * to_i_of_b.transpose();
  const Matrix6d by_odometry = start.covariance + to_i_of_end * end.covariance * to_i_of_end.transpose();
  if (loop_share) {
    const Matrix6d by_loops = covariance(a) + by_b;
    *loop_share = (by_loops + by_odometry).ldlt().solve(by_loops).trace();
  }
  return squared_sigmas(a, {before_end * end.T_from_to, by_b + by_odometry});
}

double measured_loop_scale(const IndexedGraph& graph, const OdometryForest& odometry) {
  std::vector<size_t> loops;
  for (size_t e = 0; e < graph.edges.size(); ++e) {
    const IndexedEdge& edge = graph.edges[e];
    if (edge.is_loop && edge.is_informative() && odometry.tree(edge.from) == odometry.tree(edge.to)) {
      loops.push_back(e);
    }
  }
  std::vector<double> squares;
  for (const size_t a : loops) {
    const IndexedEdge* nearest = nullptr;
    int least = std::numeric_limits<int>::max();
    for (const size_t b : loops) {
      const IndexedEdge &one = graph.edges[a], &other = graph.edges[b];
      if (a == b || odometry.tree(one.from) != odometry.tree(other.from)) continue;
      const int distance = std::abs(one.from - other.from) + std::abs(one.to - other.to);
      if (distance < least) least = distance, nearest = &other;
    }
    if (!nearest) continue;
    double loop_share = 0;
    const double square = cycle_squared_sigmas(odometry, graph.edges[a], *nearest, &loop_share);
    // The scale is read off the quotient, which holds where odometry between the two hardly counts.
    if (loop_share > 3) squares.push_back(square);
  }
  const auto scale_at = [&squares](double share, double chi_square) {
    std::vector<double> values(kScalePriorLoops, chi_square);
    values.insert(values.end(), squares.begin(), squares.end());
    return quantile(std::move(values), share) / chi_square;
  };
  const double scale = std::max(scale_at(0.25, kChiSquare25), std::min(1.0, scale_at(0.5, kChiSquare50)));
  return std::clamp(scale, kLoopScaleMin, kLoopScaleMax);
}

}  // namespace kt
