// Adds up covariances along edges and weighs errors by them.
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/eval/consistency.h"

#include <Eigen/Cholesky>
#include <map>
#include <string>
#include <vector>

#include "shared/core/check.h"

namespace kt {
namespace {

/// How a pose was measured: the edge that ends at it.
struct Measurement {
  size_t from = 0;  ///< index of the pose that it begins at, which comes earlier
  Matrix6d covariance = Matrix6d::Zero();
};

/// For each pose; nothing where no edge ends at it, or none with a covariance.
using Measurements = std::vector<std::optional<Measurement>>;

/// trajectory.txt has nine decimals.
void check_same_poses(const Trajectory& estimate, const PoseGraph& graph) {
  constexpr double kTolerance = 1e-6;  // rad and m
  if (graph.nodes.size() != estimate.size()) {
    throw Error("the pose graph has " + std::to_string(graph.nodes.size()) + " nodes, the trajectory " +
                std::to_string(estimate.size()) + " poses: they are not of one map");
  }
  for (size_t k = 0; k < estimate.size(); ++k) {
    const Eigen::Matrix4d difference =
        graph.nodes[k].T_world_node.matrix() - estimate[k].T_odom_camera.matrix();
    if (!(difference.cwiseAbs().maxCoeff() < kTolerance)) {
      throw Error("node " + std::to_string(graph.nodes[k].id) + " of the pose graph does not stand at pose " +
                  std::to_string(k + 1) + " of the trajectory: they are not of one map");
    }
  }
}

Measurements measurements_of(const PoseGraph& graph) {
  std::map<int64_t, size_t> index_of;
  for (size_t k = 0; k < graph.nodes.size(); ++k) index_of[graph.nodes[k].id] = k;
  Measurements measurements(graph.nodes.size());
  std::vector<bool> is_measured(graph.nodes.size());
  for (const PoseGraph::Edge& edge : graph.edges) {
    const size_t from = index_of.at(edge.from), to = index_of.at(edge.to);
    if (from >= to || is_measured[to]) continue;  // a loop closure
    is_measured[to] = true;
    if (const auto covariance = covariance_of(edge.information)) measurements[to] = {from, *covariance};
  }
  return measurements;
}

/// Covariance of the left perturbation of T_from_to; none where the chain is broken.
std::optional<Matrix6d> covariance_between(const Trajectory& estimate, const Measurements& measurements,
                                           size_t from, size_t to) {
  const Pose T_from_odom = estimate[from].T_odom_camera.inverse();
  Matrix6d covariance = Matrix6d::Zero();
  size_t a = from, b = to;
  while (a != b) {
    size_t& later = a > b ? a : b;  // edges begin at earlier poses, so this one cannot be where the two meet
    const std::optional<Measurement>& measurement = measurements[later];
    if (!measurement) return std::nullopt;
    later = measurement->from;
    const Matrix6d A = adjoint(T_from_odom * estimate[later].T_odom_camera);
    covariance += A * measurement->covariance * A.transpose();
  }
  return covariance;
}

template <int kSize>
double squared_per_dimension(const Eigen::Matrix<double, kSize, 1>& xi,
                             const Eigen::Matrix<double, kSize, kSize>& covariance) {
  return xi.dot(covariance.llt().solve(xi)) / kSize;
}

}  // namespace

void NeesSamples::add(const Vector6d& xi, const Matrix6d& covariance) {
  pose_.push_back(squared_per_dimension<6>(xi, covariance));
  rotation_.push_back(squared_per_dimension<3>(xi.head<3>(), covariance.topLeftCorner<3, 3>()));
  translation_.push_back(squared_per_dimension<3>(xi.tail<3>(), covariance.bottomRightCorner<3, 3>()));
}

std::optional<Consistency> NeesSamples::summary(int64_t pairs_left_out) const {
  if (pose_.empty()) return std::nullopt;
  return Consistency{summarise(pose_), summarise(rotation_), summarise(translation_),
                     static_cast<int64_t>(pose_.size()), pairs_left_out};
}

std::optional<Matrix6d> covariance_of(const Matrix6d& information) {
  const Eigen::LLT<Matrix6d> cholesky(information);
  if (cholesky.info() != Eigen::Success) return std::nullopt;
  return cholesky.solve(Matrix6d::Identity());
}

std::optional<Consistency> consistency(const Trajectory& groundtruth, const Trajectory& estimate,
                                       const PoseGraph& graph, double delta, DeltaUnit unit) {
  check_same_poses(estimate, graph);
  const Measurements measurements = measurements_of(graph);
  NeesSamples samples;
  int64_t left_out = 0;
  for (const RelativeError& pair : relative_errors(groundtruth, estimate, delta, unit)) {
    const std::optional<Matrix6d> C = covariance_between(estimate, measurements, pair.from, pair.to);
    if (C) {
      samples.add(log_se3(pair.E), *C);
    } else {
      ++left_out;
    }
  }
  return samples.summary(left_out);
}

}  // namespace kt
