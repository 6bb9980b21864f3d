// Scale of odometry, joining of segments, gate, and graduated non-convexity.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/pose_graph/robust_loops.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "offboard/pose_graph/chordal.h"
#include "offboard/pose_graph/least_squares.h"
#include "offboard/pose_graph/odometry_forest.h"

namespace kt {
namespace {

/// Most loops between two segments that are tried as the one to join them by.
constexpr size_t kMaxJoiningTried = 200;

std::vector<double> scales_of_odometry(const IndexedGraph& graph, double scale) {
  std::vector<double> result;
  for (const IndexedEdge& edge : graph.edges) result.push_back(edge.is_loop ? 0 : scale);
  return result;
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// The factor on odometry's covariance at which the loops within segments lie as far from it as they should.
double measured_scale(const IndexedGraph& graph, const OdometryForest& odometry) {
  struct Sample {
    Vector6d error;
    Matrix6d odometry, loop;
  };
  std::vector<Sample> samples;
  for (const IndexedEdge& edge : graph.edges) {
    if (!edge.is_loop || !edge.is_informative() || odometry.tree(edge.from) != odometry.tree(edge.to)) continue;
    const OdometryForest::Motion motion = odometry.between(edge.from, edge.to);
    const Matrix6d loop = edge.information.llt().solve(Matrix6d::Identity());
    // Short loops, whose own noise hides that of odometry, do not tell.
    const Matrix6d total = motion.covariance + loop;
    if (total.ldlt().solve(motion.covariance).trace() < 3) continue;
    samples.push_back({log_se3(motion.T_from_to * edge.T_from_to.inverse(Eigen::Isometry)),
                       motion.covariance, loop});
  }
  if (samples.empty()) return 1;
  const auto is_too_small = [&samples](double scale) {
    std::vector<double> squares(kScalePriorLoops, kChiSquareMedian / scale);
    for (const Sample& sample : samples) {
      const Matrix6d covariance = scale * sample.odometry + sample.loop;
      squares.push_back(sample.error.dot(covariance.ldlt().solve(sample.error)));
    }
    return median(std::move(squares)) > kChiSquareMedian;
  };
  double low = std::log(kScaleMin), high = std::log(kScaleMax);
  for (int step = 0; step < 20; ++step) {
    const double middle = (low + high) / 2;
    (is_too_small(std::exp(middle)) ? low : high) = middle;
  }
  return std::exp((low + high) / 2);
}

/// Of the way i -> j by `a`, back by `b` and by odometry at both ends: how far from none it is, in sigmas squared.
double cycle_squared_sigmas(const OdometryForest& odometry, const IndexedEdge& a, const IndexedEdge& b) {
  const bool is_same_way = odometry.tree(a.from) == odometry.tree(b.from);
  const OdometryForest::Motion start = odometry.between(a.from, is_same_way ? b.from : b.to);
  const OdometryForest::Motion end = odometry.between(is_same_way ? b.to : b.from, a.to);
  // What the detour over b says of a, T_i_j = start * b * end, with its covariance in the frame of i.
  const Pose T_b = is_same_way ? b.T_from_to : b.T_from_to.inverse(Eigen::Isometry);
  const Pose before_end = start.T_from_to * T_b;
  const Matrix6d to_i_of_b = adjoint(is_same_way ? start.T_from_to : before_end);
  const Matrix6d to_i_of_end = adjoint(before_end);
  const Matrix6d covariance_b = b.information.llt().solve(Matrix6d::Identity());
  return squared_sigmas(a, {before_end * end.T_from_to,
                            start.covariance + to_i_of_b * covariance_b * to_i_of_b.transpose() +
                                to_i_of_end * end.covariance * to_i_of_end.transpose()});
}

/// Adds, to the scales of odometry, one loop for each two segments that enough of the `usable` loops join.
std::vector<double> joined(const IndexedGraph& graph, const std::vector<char>& usable, double scale) {
  std::vector<double> scales = scales_of_odometry(graph, scale);
  for (;;) {
    const OdometryForest forest(graph, scales);
    std::map<std::pair<int, int>, std::vector<size_t>> loops_of_trees;
    for (size_t e = 0; e < graph.edges.size(); ++e) {
      const IndexedEdge& edge = graph.edges[e];
      if (!edge.is_loop || !usable[e]) continue;
      const int a = forest.tree(edge.from), b = forest.tree(edge.to);
      if (a != b) loops_of_trees[std::minmax(a, b)].push_back(e);
    }
    int most = kLoopsToJoin - 1;
    size_t best = 0;
    for (const auto& [trees, loops] : loops_of_trees) {
      const size_t step = 1 + (loops.size() - 1) / kMaxJoiningTried;
      for (size_t tried = 0; tried < loops.size(); tried += step) {
        const IndexedEdge& one = graph.edges[loops[tried]];
        const auto agrees = [&](size_t e) {
          return cycle_squared_sigmas(forest, one, graph.edges[e]) < kInformationDoubt * kChiSquare999;
        };
        const int agreeing = static_cast<int>(std::count_if(loops.begin(), loops.end(), agrees));
        if (agreeing > most) most = agreeing, best = loops[tried];
      }
    }
    if (most < kLoopsToJoin) return scales;
    scales[best] = 1;
  }
}

/// Rejects the loops between trees of `forest`.
void reject_unconfirmed(const IndexedGraph& graph, const OdometryForest& forest, LoopDecision& decision) {
  for (size_t e = 0; e < graph.edges.size(); ++e) {
    const IndexedEdge& edge = graph.edges[e];
    if (!edge.is_loop || decision.weight[e] <= 0 || forest.tree(edge.from) == forest.tree(edge.to)) continue;
    decision.weight[e] = 0;
    decision.outcome[e] = LoopOutcome::kUnconfirmed;
  }
}

std::vector<char> accepted_loops(const IndexedGraph& graph, const LoopDecision& decision) {
  std::vector<char> result;
  for (size_t e = 0; e < graph.edges.size(); ++e) {
    result.push_back(graph.edges[e].is_loop && decision.weight[e] > 0);
  }
  return result;
}

/// Yang et al. 2020, eq. 14: weight of a residual in truncated least squares at convexity `mu`.
double truncated_weight(double square, double threshold, double mu) {
  if (square >= (mu + 1) / mu * threshold) return 0;
  if (square <= mu / (mu + 1) * threshold) return 1;
  return std::sqrt(threshold / square * mu * (mu + 1)) - mu;
}

void graduate(const IndexedGraph& graph, LoopDecision& decision, std::vector<Pose>& T_world_node) {
  constexpr double kThreshold = kInformationDoubt * kChiSquare99;
  constexpr double kMuStep = 1.4;  // as in the paper
  const std::vector<char> is_tried = accepted_loops(graph, decision);
  std::vector<double> weight = decision.weight;
  for (size_t e = 0; e < graph.edges.size(); ++e) {
    if (!graph.edges[e].is_loop) weight[e] /= decision.odometry_scale;
  }
  LeastSquaresOptions options;
  options.max_iterations = 10;
  options.relative_tolerance = 1e-4;
  double mu = 0;
  for (;;) {
    solve(graph, weight, options, T_world_node);
    ++decision.solves;
    const std::vector<double> squares = squared_errors(graph, GraphResidual::kSe3, T_world_node);
    double largest = 0;
    for (size_t e = 0; e < squares.size(); ++e) {
      if (is_tried[e]) largest = std::max(largest, squares[e]);
    }
    if (mu == 0) {
      if (largest <= kThreshold) return;
      mu = kThreshold / (2 * largest - kThreshold);
    }
    bool is_undecided = false;
    for (size_t e = 0; e < squares.size(); ++e) {
      if (!is_tried[e]) continue;
      weight[e] = truncated_weight(squares[e], kThreshold, mu);
      is_undecided |= weight[e] > 0 && weight[e] < 1;
    }
    if (!is_undecided) break;
    mu *= kMuStep;
  }
  for (size_t e = 0; e < weight.size(); ++e) {
    if (!is_tried[e] || weight[e] > 0) continue;
    decision.weight[e] = 0;
    decision.outcome[e] = LoopOutcome::kInconsistent;
  }
}

}  // namespace

const char* to_string(LoopOutcome outcome) {
  switch (outcome) {
    case LoopOutcome::kAccepted: return "accepted";
    case LoopOutcome::kUnconfirmed: return "unconfirmed";
    case LoopOutcome::kAgainstOdometry: return "against odometry";
    case LoopOutcome::kInconsistent: return "inconsistent";
    case LoopOutcome::kUninformative: return "uninformative";
  }
  return "";
}

LoopDecision decide_loops(const IndexedGraph& graph, std::vector<Pose>& T_world_node) {
  LoopDecision decision;
  decision.weight.assign(graph.edges.size(), 1);
  decision.outcome.assign(graph.edges.size(), LoopOutcome::kAccepted);
  for (size_t e = 0; e < graph.edges.size(); ++e) {
    if (!graph.edges[e].is_loop || graph.edges[e].is_informative()) continue;
    decision.weight[e] = 0;
    decision.outcome[e] = LoopOutcome::kUninformative;
  }
  decision.odometry_scale =
      measured_scale(graph, OdometryForest(graph, scales_of_odometry(graph, 1)));
  const auto join = [&] {
    return OdometryForest(graph, joined(graph, accepted_loops(graph, decision), decision.odometry_scale));
  };
  const OdometryForest forest = join();
  reject_unconfirmed(graph, forest, decision);
  for (size_t e = 0; e < graph.edges.size(); ++e) {
    const IndexedEdge& edge = graph.edges[e];
    if (!edge.is_loop || decision.weight[e] <= 0) continue;
    if (squared_sigmas(edge, forest.between(edge.from, edge.to)) < kInformationDoubt * kChiSquare999) continue;
    decision.weight[e] = 0;
    decision.outcome[e] = LoopOutcome::kAgainstOdometry;
  }
  T_world_node = chordal_initialisation(graph, decision.weight);
  graduate(graph, decision, T_world_node);
  reject_unconfirmed(graph, join(), decision);  // fewer may be left that agree
  return decision;
}

}  // namespace kt
