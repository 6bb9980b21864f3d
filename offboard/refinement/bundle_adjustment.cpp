// One problem for Ceres.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/refinement/bundle_adjustment.h"

#include <array>
#include <ceres/loss_function.h>
#include <ceres/problem.h>
#include <ceres/solver.h>
#include <cmath>
#include <memory>

#include "offboard/pose_graph/edge_costs.h"
#include "offboard/refinement/held_back.h"
#include "shared/core/check.h"

namespace kt {
namespace {

// How well cameras are calibrated anyway: 2 % of the focal length, 10 pixels, 20 milliseconds.
constexpr std::array<double, 3> kIntrinsicsPrior = {0.02, 10, 10};
constexpr double kDelayPrior_s = 0.02;

/// (x - 0) / sigma.
class PriorCost : public ceres::CostFunction {
 public:
  explicit PriorCost(std::span<const double> sigmas) : sigmas_(sigmas) {
    set_num_residuals(static_cast<int>(sigmas.size()));
    mutable_parameter_block_sizes()->push_back(static_cast<int>(sigmas.size()));
  }
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    const size_t count = sigmas_.size();
    for (size_t i = 0; i < count; ++i) {
      residuals[i] = parameters[0][i] / sigmas_[i];
      for (size_t j = 0; jacobians && jacobians[0] && j < count; ++j)
        jacobians[0][i * count + j] = i == j ? 1 / sigmas_[i] : 0;
    }
    return true;
  }

 private:
  std::span<const double> sigmas_;
};

/// What Ceres sees: plain doubles.
struct Parameters {
  std::vector<std::array<double, kPoseParameters>> poses;
  std::vector<std::array<double, 3>> points;
  std::array<double, 3> intrinsics;
  double delay;
};

Parameters parameters_of(const BundleState& state, const FeatureViews& views,
                         std::span<const FeatureTrack> tracks) {
  Parameters parameters;
  parameters.poses.resize(state.T_world_node.size());
  for (size_t node = 0; node < state.T_world_node.size(); ++node)
    write_parameters(state.T_world_node[node], parameters.poses[node].data());
  for (const FeatureTrack& track : tracks) {
    const Eigen::Vector3d p_world = locate(views, track, state).p_world;
    parameters.points.push_back({p_world.x(), p_world.y(), p_world.z()});
  }
  const CalibrationChange& change = state.change;
  parameters.intrinsics = {change.focal, change.centre_px.x(), change.centre_px.y()};
  parameters.delay = change.colour_delay_s;
  return parameters;
}

ceres::Solver::Options solver_options(const BundleOptions& options) {
  ceres::Solver::Options result;
  result.linear_solver_type = ceres::SPARSE_SCHUR;
  result.sparse_linear_algebra_library_type = ceres::EIGEN_SPARSE;
  result.max_num_iterations = options.max_iterations;
  result.function_tolerance = 1e-5;
  result.num_threads = 1;
  result.logging_type = ceres::SILENT;
  return result;
}

}  // namespace

void adjust(const IndexedGraph& graph, std::span<const double> weight, const FeatureViews& views,
            std::span<const FeatureTrack> tracks, const BundleOptions& options, BundleState& state) {
  Parameters parameters = parameters_of(state, views, tracks);
  LeftPerturbation perturbation;
  ceres::CauchyLoss loss(kRobustSigmas);
  ceres::Problem::Options shared;
  shared.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  shared.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ceres::Problem problem(shared);
  for (auto& pose : parameters.poses) problem.AddParameterBlock(pose.data(), kPoseParameters, &perturbation);
  for (const int anchor : connected_components(graph, weight).anchor)
    problem.SetParameterBlockConstant(parameters.poses[static_cast<size_t>(anchor)].data());
  for (size_t e = 0; e < graph.edges.size(); ++e) {
    const IndexedEdge& edge = graph.edges[e];
    if (!edge.is_informative() || weight[e] <= 0) continue;
    problem.AddResidualBlock(new Se3Cost(edge, weight[e]), nullptr,
                             parameters.poses[static_cast<size_t>(edge.from)].data(),
                             parameters.poses[static_cast<size_t>(edge.to)].data());
  }
  auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
  for (size_t t = 0; t < tracks.size(); ++t) {
    double* const point = parameters.points[t].data();
    for (const Observation& seen : tracks[t]) {
      const auto k = static_cast<size_t>(seen.keyframe);
      problem.AddResidualBlock(new ObservationCost(views.model, seen, views.velocity[k], options.scale),
                               &loss, parameters.poses[static_cast<size_t>(views.node[k])].data(), point,
                               parameters.intrinsics.data(), &parameters.delay);
    }
    ordering->AddElementToGroup(point, 0);
  }
  problem.AddResidualBlock(new PriorCost(kIntrinsicsPrior), nullptr, parameters.intrinsics.data());
  problem.AddResidualBlock(new PriorCost({&kDelayPrior_s, 1}), nullptr, &parameters.delay);
  if (!options.intrinsics) problem.SetParameterBlockConstant(parameters.intrinsics.data());
  if (!options.delay) problem.SetParameterBlockConstant(&parameters.delay);
  for (auto& pose : parameters.poses) ordering->AddElementToGroup(pose.data(), 1);
  ordering->AddElementToGroup(parameters.intrinsics.data(), 1);
  ordering->AddElementToGroup(&parameters.delay, 1);

  ceres::Solver::Options solver = solver_options(options);
  solver.linear_solver_ordering = ordering;
  ceres::Solver::Summary summary;
  ceres::Solve(solver, &problem, &summary);
  if (!summary.IsSolutionUsable()) throw Error("refinement: the optimiser failed: " + summary.message);
  for (size_t node = 0; node < state.T_world_node.size(); ++node) {
    if (!problem.IsParameterBlockConstant(parameters.poses[node].data()))
      state.T_world_node[node] = orthonormalised(pose_of_parameters(parameters.poses[node].data()));
  }
  state.change = {
      parameters.intrinsics[0], {parameters.intrinsics[1], parameters.intrinsics[2]}, parameters.delay};
}

}  // namespace kt
