// The steps of Gauss-Newton and the guards around them.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/deformation/solve_deformation.h"

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>

namespace kt {
namespace {

// Added to the diagonal of the normal equations, whose entries are of the order of 1 and more: what no term
// determines stays where it is, what one does is hardly held back.
constexpr double kDamping = 1e-6;

// Residuals of a nanometre are rounding.
constexpr double kNothing_m = 1e-9;

double largest_stretch(const DeformationGraph& graph) {
  double largest = 0;
  for (const auto& [l, k] : graph.edges) {
    const DeformationNode &a = graph.nodes[static_cast<size_t>(l)], &b = graph.nodes[static_cast<size_t>(k)];
    const double before = (b.g_odom - a.g_odom).norm();
    const double after = (b.g_odom + b.t - a.g_odom - a.t).norm();
    largest = std::max(largest, std::abs(after - before) / std::max(before, graph.config.node_spacing_m));
  }
  return largest;
}

}  // namespace

DeformationReport solve(DeformationGraph& graph, std::span<const PointConstraint> constraints) {
  DeformationReport report;
  if (graph.nodes.empty()) return report;
  const DeformationConfig& config = graph.config;
  const DeformationProblem problem(graph, constraints);
  report.nodes = static_cast<int>(graph.nodes.size());
  report.constraints = problem.constraints();

  Eigen::VectorXd x = problem.unknowns_of(graph);
  report.before = report.after = problem.energy(x);
  report.converged = report.before.total() <= problem.rows() * kNothing_m * kNothing_m;
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> cholesky;
  while (!report.converged && report.iterations < config.max_iterations) {
    const auto [residuals, J] = problem.linearise(x);
    Eigen::SparseMatrix<double> H = J.transpose() * J;
    for (int i = 0; i < H.cols(); ++i) H.coeffRef(i, i) += kDamping;
    if (report.iterations == 0) cholesky.analyzePattern(H);
    cholesky.factorize(H);
    if (cholesky.info() != Eigen::Success) break;
    const Eigen::VectorXd moved = x - cholesky.solve(J.transpose() * residuals);
    const DeformationEnergy energy = problem.energy(moved);
    const double decrease = report.after.total() - energy.total();
    report.converged = std::abs(decrease) <= config.min_relative_decrease * report.after.total();
    if (!(decrease > 0)) break;  // worse, or not a number
    x = moved;
    report.after = energy;
    ++report.iterations;
  }
  if (report.iterations > 0) problem.set_unknowns(x, graph);

  report.largest_stretch = largest_stretch(graph);
  report.accepted = report.largest_stretch <= config.max_stretch;
  if (!report.accepted) {
    for (DeformationNode& node : graph.nodes) {
      node.R.setIdentity();
      node.t.setZero();
    }
  }
  return report;
}

}  // namespace kt
