// Residuals of edges: what their squares mean, and their Jacobians against numeric ones.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/pose_graph/edge_costs.h"

#include <Eigen/Cholesky>
#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <memory>

#include "offboard/pose_graph/chordal.h"
#include "offboard/pose_graph/least_squares.h"

namespace kt {
namespace {

Vector6d made_tangent(double scale, int seed) {
  Vector6d xi;
  for (int k = 0; k < 6; ++k) xi[k] = scale * std::sin(1.7 * k + 0.9 * seed + 0.3);
  return xi;
}

/// Positive definite, with every entry in use.
Matrix6d full_information() {
  Matrix6d A;
  for (int k = 0; k < 36; ++k) A(k / 6, k % 6) = std::cos(0.7 * k * k + 1);
  return A * A.transpose() + 3 * Matrix6d::Identity();
}

/// An edge whose present poses disagree with it by about `error`.
struct Scene {
  PoseGraph graph;
  std::array<std::array<double, kPoseParameters>, 2> poses;
  IndexedEdge edge;

  explicit Scene(double error) {
    const Pose T_i = exp_se3(made_tangent(1.1, 1)), T_ij = exp_se3(made_tangent(0.8, 2));
    graph.nodes = {{0, T_i, true}, {1, T_i * exp_se3(made_tangent(error, 3)) * T_ij, false}};
    graph.edges = {{0, 1, T_ij, full_information()}};
    edge = indexed(graph).edges[0];
    for (int k = 0; k < 2; ++k) write_parameters(graph.nodes[k].T_world_node, poses[k].data());
  }
};

void expect_right_jacobians(const ceres::CostFunction& cost, const Scene& scene) {
  std::array<double, 6> residuals, plus, minus;
  std::array<std::array<double, 6 * kPoseParameters>, 2> jacobians;
  double* rows[2] = {jacobians[0].data(), jacobians[1].data()};
  const double* poses[2] = {scene.poses[0].data(), scene.poses[1].data()};
  ASSERT_TRUE(cost.Evaluate(poses, residuals.data(), rows));
  const LeftPerturbation manifold;
  constexpr double kStep = 1e-6;
  for (int pose = 0; pose < 2; ++pose) {
    for (int axis = 0; axis < 6; ++axis) {
      std::array<double, kPoseParameters> moved;
      const double* there[2] = {poses[0], poses[1]};
      there[pose] = moved.data();
      Vector6d xi = Vector6d::Zero();
      xi[axis] = kStep;
      manifold.Plus(poses[pose], xi.data(), moved.data());
      cost.Evaluate(there, plus.data(), nullptr);
      xi[axis] = -kStep;
      manifold.Plus(poses[pose], xi.data(), moved.data());
      cost.Evaluate(there, minus.data(), nullptr);
      for (int row = 0; row < 6; ++row) {
        EXPECT_NEAR(jacobians[pose][kPoseParameters * row + axis], (plus[row] - minus[row]) / (2 * kStep),
                    2e-7)
            << "pose " << pose << " row " << row << " axis " << axis;
      }
    }
  }
}

TEST(EdgeCosts, JacobiansAreThoseOfTheLeftPerturbation) {
  for (const double error : {0.0, 0.003, 0.05, 0.7, 1.3}) {
    SCOPED_TRACE(error);
    const Scene scene(error);
    expect_right_jacobians(Se3Cost(scene.edge, 0.5), scene);
    expect_right_jacobians(ChordalCost(scene.edge, 0.5), scene);
  }
}

TEST(EdgeCosts, SquareIsThatOfTheWholeInformationMatrix) {
  const Scene scene(0.4);
  const Pose T_i_j =
      scene.graph.nodes[0].T_world_node.inverse(Eigen::Isometry) * scene.graph.nodes[1].T_world_node;
  const Vector6d e = log_se3(T_i_j * scene.edge.T_from_to.inverse(Eigen::Isometry));
  const std::vector<Pose> poses = {scene.graph.nodes[0].T_world_node, scene.graph.nodes[1].T_world_node};
  const double square = squared_errors(indexed(scene.graph), GraphResidual::kSe3, poses)[0];
  const double expected = e.dot(full_information() * e);
  EXPECT_NEAR(square, expected, 1e-9 * expected);
  // The mistake of the Ceres example gives another one.
  const Matrix6d L = full_information().llt().matrixL();
  EXPECT_GT(std::abs((L * e).squaredNorm() - expected), 0.01 * expected);
}

TEST(EdgeCosts, ChordalSquareIsTheMatrixNorm) {
  const Scene scene(0.4);
  const std::vector<Pose> poses = {scene.graph.nodes[0].T_world_node, scene.graph.nodes[1].T_world_node};
  const double square = squared_errors(indexed(scene.graph), GraphResidual::kChordal, poses)[0];
  EXPECT_NEAR(square, chordal_objective(scene.graph, poses), 1e-9 * square);
}

TEST(EdgeCosts, InverseLeftJacobianAgreesOnBothSidesOfItsSeries) {
  for (const double size : {1e-9, 0.08, 0.1005, 0.1995, 0.2005, 2.5}) {
    SCOPED_TRACE(size);
    Vector6d xi;
    xi << size * Eigen::Vector3d(1, 2, -2) / 3, 0.4, -0.7, 0.2;
    const Matrix6d J = inverse_left_jacobian(xi);
    for (int axis = 0; axis < 6; ++axis) {
      Vector6d delta = Vector6d::Zero();
      delta[axis] = 1e-6;
      const Vector6d numeric =
          (log_se3(exp_se3(delta) * exp_se3(xi)) - log_se3(exp_se3(-delta) * exp_se3(xi))) / 2e-6;
      EXPECT_LT((numeric - J.col(axis)).norm(), 2e-7) << axis;
    }
  }
}

TEST(EdgeCosts, MinusUndoesPlus) {
  const Scene scene(0.2);
  const LeftPerturbation manifold;
  const Vector6d xi = made_tangent(0.3, 4);
  std::array<double, kPoseParameters> moved;
  Vector6d back;
  manifold.Plus(scene.poses[0].data(), xi.data(), moved.data());
  manifold.Minus(moved.data(), scene.poses[0].data(), back.data());
  EXPECT_LT((back - xi).norm(), 1e-12);
}

}  // namespace
}  // namespace kt
