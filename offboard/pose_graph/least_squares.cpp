// Builds the Ceres problem of a pose graph and solves it.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/pose_graph/least_squares.h"

#include <algorithm>
#include <array>
#include <ceres/problem.h>
#include <ceres/solver.h>
#include <memory>

#include "offboard/pose_graph/edge_costs.h"
#include "offboard/pose_graph/fill.h"
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
  if (options.linear_solver == LinearSolver::kConjugateGradients) {
    result.linear_solver_type = ceres::CGNR;
    result.preconditioner_type = ceres::SUBSET;
  }
  return result;
}

/// Whether each edge belongs to the preconditioner. The loops that err least are true ones mostly, which tie
/// places to their surroundings and fill the factor little.
std::vector<char> preconditioning_edges(const IndexedGraph& graph, std::span<const double> weight,
                                        const std::vector<double>& squares) {
  const auto weight_of = [&](size_t e) { return weight.empty() ? 1 : weight[e]; };
  std::vector<double> sorted;
  for (size_t e = 0; e < squares.size(); ++e) {
    if (graph.edges[e].is_loop && weight_of(e) > 0) sorted.push_back(squares[e]);
  }
  std::sort(sorted.begin(), sorted.end());
  std::vector<char> is_chosen(squares.size());
  const auto choose = [&](size_t loops) {
    for (size_t e = 0; e < squares.size(); ++e) {
      is_chosen[e] = !graph.edges[e].is_loop || loops == sorted.size() || squares[e] < sorted[loops];
    }
  };
  const auto is_cheap = [&](size_t loops) {
    choose(loops);
    std::vector<double> chosen_weight;
    for (size_t e = 0; e < squares.size(); ++e) chosen_weight.push_back(is_chosen[e] ? weight_of(e) : 0);
    return factorisation_cost(graph, chosen_weight) < kDearFactorisation;
  };
  size_t cheap = 0, dear = sorted.size();
  const size_t near_enough = 1 + sorted.size() / 50;
  while (dear - cheap > near_enough) {
    const size_t middle = (cheap + dear) / 2;
    (is_cheap(middle) ? cheap : dear) = middle;
  }
  choose(cheap);
  return is_chosen;
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
  ceres::Solver::Options solver = ceres_options(options);
  std::vector<char> preconditions(graph.edges.size());
  if (options.linear_solver == LinearSolver::kConjugateGradients) {
    preconditions =
        preconditioning_edges(graph, weight, squared_errors(graph, options.residual, T_world_node));
  }
  for (size_t e = 0; e < graph.edges.size(); ++e) {
    const double factor = weight.empty() ? 1 : weight[e];
    const IndexedEdge& edge = graph.edges[e];
    if (!edge.is_informative() || factor <= 0) continue;
    const ceres::ResidualBlockId block =
        problem.AddResidualBlock(make_cost(edge, options.residual, factor).release(), nullptr,
                                 parameters[edge.from].data(), parameters[edge.to].data());
    if (preconditions[e]) solver.residual_blocks_for_subset_preconditioner.insert(block);
  }
  ceres::Solver::Summary summary;
  ceres::Solve(solver, &problem, &summary);
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
