// Tests of the solution: rigid motions, bent paths made straight, and what cannot or must not be bent.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/deformation/solve_deformation.h"

#include <algorithm>
#include <gtest/gtest.h>
#include <numeric>

#include "offboard/deformation/deform.h"
#include "tests/offboard/deformation/made_paths.h"

namespace kt {
namespace {

struct Solution {
  DeformationGraph graph;
  DeformationReport report;
};

Solution solved(const Trajectory& before, std::span<const Pose> after, const DeformationConfig& config = {}) {
  Solution solution{build_deformation_graph(before, after, config), {}};
  solution.report = solve(solution.graph, camera_constraints(before, after, config));
  return solution;
}

// Vertices up to a metre around the view centre of every tenth frame, and where they truly are.
struct Surface {
  std::vector<SliceVertex> vertices;
  std::vector<Eigen::Vector3d> p_world;
};

Surface surface_of(const Trajectory& before, const std::vector<Pose>& truth) {
  Surface surface;
  for (size_t i = 0; i < before.size(); i += 10) {
    const Eigen::Vector3d p_camera =
        Eigen::Vector3d(0, 0, 1.5) + test::random_point(9, static_cast<int64_t>(i));
    surface.vertices.push_back(test::vertex_at(before[i].T_odom_camera * p_camera, before[i].sequence));
    surface.p_world.push_back(truth[i] * p_camera);
  }
  return surface;
}

std::vector<double> errors_m(const Surface& surface) {
  std::vector<double> errors;
  for (size_t i = 0; i < surface.vertices.size(); ++i)
    errors.push_back((to_eigen(surface.vertices[i].p_odom) - surface.p_world[i]).norm());
  return errors;
}

double largest_error_m(const Surface& surface) { return std::ranges::max(errors_m(surface)); }

double mean_error_m(const Surface& surface) {
  const std::vector<double> errors = errors_m(surface);
  return std::accumulate(errors.begin(), errors.end(), 0.0) / static_cast<double>(errors.size());
}

TEST(SolveDeformation, ReproducesARigidMotionOfAllPoses) {
  const Pose T_world_odom = test::made_pose({0.4, -1.1, 2.0}, {3, -8, 5});
  for (const int frames : {1, 30, 60, 400}) {  // one node, two, three, many
    const std::vector<Pose> path = test::arc_path(frames, 0.3);
    std::vector<Pose> after;
    for (const Pose& pose : path) after.push_back(T_world_odom * pose);
    const Solution solution = solved(test::trajectory_of(path), after);
    EXPECT_EQ(solution.report.iterations, 0);
    EXPECT_TRUE(solution.report.converged);
    EXPECT_LT(solution.report.largest_stretch, 1e-12);
    Surface surface = surface_of(test::trajectory_of(path), after);
    deform(solution.graph, surface.vertices);
    EXPECT_LT(largest_error_m(surface), 5e-6) << "float rounds at 20 m to a micrometre";
  }
}

TEST(SolveDeformation, StraightensABentPath) {
  constexpr int kFrames = 1000;  // 20 m, in the end 34 degrees off
  const std::vector<Pose> truth = test::straight_path(kFrames);
  const Trajectory before = test::trajectory_of(test::arc_path(kFrames, 0.03));
  Surface surface = surface_of(before, truth);
  EXPECT_GT(largest_error_m(surface), 5);
  const Solution solution = solved(before, truth);
  EXPECT_TRUE(solution.report.converged);
  EXPECT_TRUE(solution.report.accepted);
  EXPECT_LE(solution.report.after.total(), solution.report.before.total());
  EXPECT_LT(solution.report.largest_stretch, 0.1);
  deform(solution.graph, surface.vertices);
  // A vertex up to 1.7 m from its view centre may hang on nodes a metre along the path: 0.03 rad of bend.
  EXPECT_LT(largest_error_m(surface), 0.06);
  EXPECT_LT(mean_error_m(surface), 0.02);
}

TEST(SolveDeformation, FindsTheSameFromTheIdentity) {
  const std::vector<Pose> truth = test::straight_path(500);
  const Trajectory before = test::trajectory_of(test::arc_path(500, 0.03));
  const Solution expected = solved(before, truth);
  DeformationGraph graph = build_deformation_graph(before, truth);
  for (DeformationNode& node : graph.nodes) node.R.setIdentity(), node.t.setZero();
  const DeformationReport report = solve(graph, camera_constraints(before, truth, {}));
  EXPECT_GT(report.iterations, expected.report.iterations);
  EXPECT_NEAR(report.after.total(), expected.report.after.total(), 1e-4 * report.after.total());
  for (size_t i = 0; i < graph.nodes.size(); ++i)
    EXPECT_LT((graph.nodes[i].t - expected.graph.nodes[i].t).norm(), 0.005);
}

TEST(SolveDeformation, PosesThatDidNotChangeLeaveEveryBit) {
  const std::vector<Pose> path = test::arc_path(300, 0.3);
  const Solution solution = solved(test::trajectory_of(path), path);
  EXPECT_TRUE(solution.graph.is_identity());
  EXPECT_EQ(solution.report.iterations, 0);
  EXPECT_TRUE(solution.report.converged);
}

TEST(SolveDeformation, RotationAboutAStraightPathStaysThatOfThePoses) {
  const Trajectory before = test::trajectory_of(test::straight_path(300));
  std::vector<Pose> after;
  for (int i = 0; i < 300; ++i)
    after.push_back(test::made_pose({0, 0, 0.001 * i}, {0, 0, test::kFrameStep_m * i}));
  DeformationConfig config;
  config.node_ahead_m = config.camera_arm_m = 0;  // the paper's constraints do not see it
  const Solution solution = solved(before, after, config);
  for (const DeformationNode& node : solution.graph.nodes)
    EXPECT_LT((node.R - exp_so3({0, 0, 0.001 * static_cast<double>(node.pose_sequence)})).norm(), 1e-3);
}

TEST(SolveDeformation, RejectsWhatTearsThePathApart) {
  const std::vector<Pose> path = test::straight_path(300);
  std::vector<Pose> after = path;
  for (size_t i = 150; i < 300; ++i) after[i].translation().x() += 3;
  const Solution solution = solved(test::trajectory_of(path), after);
  EXPECT_FALSE(solution.report.accepted);
  EXPECT_GT(solution.report.largest_stretch, 0.5);
  EXPECT_TRUE(solution.graph.is_identity());
}

TEST(SolveDeformation, NeverEndsWorseThanItBegan) {
  const std::vector<Pose> after = test::straight_path(200);
  const Trajectory before = test::trajectory_of(test::arc_path(200, 0.1));
  DeformationConfig config;
  config.node_ahead_m = config.camera_arm_m = 0;  // the less is determined, the worse the steps
  config.max_stretch = 1e6;
  const auto constraints = camera_constraints(before, after, config);
  int taken_back = 0;
  for (int trial = 0; trial < 20; ++trial) {
    DeformationGraph graph = build_deformation_graph(before, after, config);
    for (size_t i = 0; i < graph.nodes.size(); ++i) {  // far from any rotation
      for (int c = 0; c < 3; ++c)
        graph.nodes[i].R.col(c) =
            0.1 * test::random_point(static_cast<uint64_t>(trial), static_cast<int64_t>(3 * i) + c);
    }
    const DeformationReport report = solve(graph, constraints);
    EXPECT_LE(report.after.total(), report.before.total());
    taken_back += report.iterations < config.max_iterations && !report.converged;
    const DeformationProblem problem(graph, constraints);
    EXPECT_NEAR(problem.energy(problem.unknowns_of(graph)).total(), report.after.total(), 1e-9);
  }
  EXPECT_GT(taken_back, 0);
}

TEST(SolveDeformation, WithoutNodesOrConstraintsDoesNothing) {
  DeformationGraph empty;
  const DeformationReport nothing = solve(empty, {});
  EXPECT_EQ(nothing.nodes, 0);
  EXPECT_TRUE(nothing.accepted);

  const std::vector<Pose> path = test::straight_path(100);
  DeformationGraph graph = build_deformation_graph(test::trajectory_of(path), path);
  EXPECT_EQ(solve(graph, {}).iterations, 0);
  EXPECT_TRUE(graph.is_identity());
}

TEST(SolveDeformation, ASingleNodeFollowsItsConstraint) {
  const std::vector<Pose> path = test::straight_path(1);
  DeformationGraph graph = build_deformation_graph(test::trajectory_of(path), path);
  const std::vector<PointConstraint> one = {{{0, 0, 2}, 0, {0.2, 0, 2}, false}};
  const DeformationReport report = solve(graph, one);
  EXPECT_LT(report.after.total(), 1e-3 * report.before.total());
}

}  // namespace
}  // namespace kt
