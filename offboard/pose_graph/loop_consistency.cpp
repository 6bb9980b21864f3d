// Cycles of two loops and odometry, and the scales of both covariances that follow from them.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/pose_graph/loop_consistency.h"

#include <Eigen/Cholesky>
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
  struct Sample {
    Vector6d error;
    Matrix6d odometry, loop;
  };
  std::vector<Sample> samples;
  for (const IndexedEdge& edge : graph.edges) {
    if (!edge.is_loop || !edge.is_informative() || odometry.tree(edge.from) != odometry.tree(edge.to))
      continue;
    const OdometryForest::Motion motion = odometry.between(edge.from, edge.to);
    const Matrix6d loop = covariance(edge);
    // Short loops, whose own noise hides that of odometry, do not tell.
    if ((motion.covariance + loop).ldlt().solve(motion.covariance).trace() < 3) continue;
    samples.push_back(
        {log_se3(motion.T_from_to * edge.T_from_to.inverse(Eigen::Isometry)), motion.covariance, loop});
  }
  const auto is_too_small = [&samples](double scale) {
    std::vector<double> squares(kScalePriorLoops, kChiSquare50 / scale);
    for (const Sample& sample : samples) {
      const Matrix6d total = scale * sample.odometry + sample.loop;
      squares.push_back(sample.error.dot(total.ldlt().solve(sample.error)));
    }
    return quantile(std::move(squares), 0.5) > kChiSquare50;
  };
  double low = std::log(kOdometryScaleMin), high = std::log(kOdometryScaleMax);
  for (int step = 0; step < 20; ++step) {
    const double middle = (low + high) / 2;
    (is_too_small(std::exp(middle)) ? low : high) = middle;
  }
  return std::exp((low + high) / 2);
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
