// Builds the Ceres problem of a pose graph and solves it.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/pose_graph/least_squares.h"

#include <array>
#include <ceres/problem.h>
#include <ceres/solver.h>
#include <memory>

#include "offboard/pose_graph/edge_costs.h"
#include "shared/core/check.h"

namespace kt {
namespace {

std::unique_ptr<ceres::CostFunction> make_cost(const IndexedEdge& edge, GraphResidual residual,
                                               double weight) {
  if (residual == GraphResidual::kChordal) return std::make_unique<ChordalCost>(edge, weight);
  return std::make_unique<Se3Cost>(edge, weight);
}

ceres::Solver::Options ceres_options(const LeastSquaresOptions& options) {
  ceres::Solver::Options result;
  result.max_num_iterations = options.max_iterations;
  result.function_tolerance = options.relative_tolerance;
  result.gradient_tolerance = 0;  // has units; the objective and the step do not
  result.parameter_tolerance = 1e-12;
  result.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  // Single-threaded and free of BLAS, whose sums depend on the machine.
  result.sparse_linear_algebra_library_type = ceres::EIGEN_SPARSE;
  result.num_threads = 1;
  result.logging_type = ceres::SILENT;
  return result;
}

}  // namespace

LeastSquaresResult solve(const IndexedGraph& graph, std::span<const double> weight,
                         const LeastSquaresOptions& options, std::vector<Pose>& T_world_node) {
  KT_CHECK(T_world_node.size() == graph.T_world_node.size());
  const Components components = connected_components(graph, weight);
  move_to_anchors(graph, components, T_world_node);

  std::vector<std::array<double, kPoseParameters>> parameters(T_world_node.size());
  for (size_t node = 0; node < T_world_node.size(); ++node) {
    write_parameters(T_world_node[node], parameters[node].data());
  }
  LeftPerturbation manifold;
  ceres::Problem::Options ownership;
  ownership.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ceres::Problem problem(ownership);
  for (auto& pose : parameters) problem.AddParameterBlock(pose.data(), kPoseParameters, &manifold);
  for (const int anchor : components.anchor) problem.SetParameterBlockConstant(parameters[anchor].data());
  for (size_t e = 0; e < graph.edges.size(); ++e) {
    const double factor = weight.empty() ? 1 : weight[e];
    const IndexedEdge& edge = graph.edges[e];
    if (!edge.is_informative() || factor <= 0) continue;
    problem.AddResidualBlock(make_cost(edge, options.residual, factor).release(), nullptr,
                             parameters[edge.from].data(), parameters[edge.to].data());
  }
  ceres::Solver::Summary summary;
  ceres::Solve(ceres_options(options), &problem, &summary);
  if (!summary.IsSolutionUsable()) throw Error("pose graph: the optimiser failed: " + summary.message);
  for (size_t node = 0; node < T_world_node.size(); ++node) {
    T_world_node[node] = orthonormalised(pose_of_parameters(parameters[node].data()));
  }
  // Ceres halves the sum of squares.
  return {2 * summary.initial_cost, 2 * summary.final_cost,
          summary.num_successful_steps + summary.num_unsuccessful_steps,
          summary.termination_type == ceres::CONVERGENCE};
}

std::vector<double> squared_errors(const IndexedGraph& graph, GraphResidual residual,
                                   std::span<const Pose> T_world_node) {
  std::vector<double> result;
  std::array<double, kPoseParameters> from, to;
  const double* const poses[2] = {from.data(), to.data()};
  std::array<double, 12> values;
  for (const IndexedEdge& edge : graph.edges) {
    const std::unique_ptr<ceres::CostFunction> cost = make_cost(edge, residual, 1);
    write_parameters(T_world_node[edge.from], from.data());
    write_parameters(T_world_node[edge.to], to.data());
    cost->Evaluate(poses, values.data(), nullptr);
    double sum = 0;
    for (int row = 0; row < cost->num_residuals(); ++row) sum += values[row] * values[row];
    result.push_back(sum);
  }
  return result;
}

}  // namespace kt
