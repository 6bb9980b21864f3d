// Tests of the energy: its derivatives against differences, its terms against the paper's equations.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/deformation/deformation_problem.h"

#include <gtest/gtest.h>

#include "tests/offboard/deformation/made_paths.h"

namespace kt {
namespace {

// A few nodes along an arc with constraints around them, some of them surface.
class DeformationProblemTest : public testing::Test {
 protected:
  DeformationProblemTest() {
    const std::vector<Pose> path = test::arc_path(200, 0.2);
    graph_ = build_deformation_graph(test::trajectory_of(path), path);
    for (int i = 0; i < 20; ++i) {
      const Eigen::Vector3d p =
          path[static_cast<size_t>(10 * i)] * (Eigen::Vector3d(0, 0, 1.5) + test::random_point(1, i));
      constraints_.push_back({p, 10 * i, p + 0.02 * test::random_point(2, i), i % 3 == 0});
    }
  }
  Eigen::VectorXd random_unknowns(const DeformationProblem& problem, double size) const {
    Eigen::VectorXd x = problem.unknowns_of(graph_);
    for (int i = 0; i < x.size(); ++i) x[i] += size * test::random_point(3, i).x();
    return x;
  }

  DeformationGraph graph_;
  std::vector<PointConstraint> constraints_;
};

TEST_F(DeformationProblemTest, DerivativesAreThoseOfTheResiduals) {
  graph_.config.huber_m = 10;  // beyond it the factor of the loss is held fixed
  const DeformationProblem problem(graph_, constraints_);
  const Eigen::VectorXd x = random_unknowns(problem, 0.2);
  const Eigen::MatrixXd J = problem.linearise(x).J;
  ASSERT_EQ(J.rows(), problem.rows());
  ASSERT_EQ(J.cols(), problem.unknowns());
  constexpr double kStep = 1e-6;
  for (int i = 0; i < x.size(); ++i) {
    Eigen::VectorXd above = x, below = x;
    above[i] += kStep, below[i] -= kStep;
    const Eigen::VectorXd difference =
        (problem.linearise(above).residuals - problem.linearise(below).residuals) / (2 * kStep);
    EXPECT_LT((J.col(i) - difference).cwiseAbs().maxCoeff(), 1e-7) << "unknown " << i;
  }
}

TEST_F(DeformationProblemTest, EnergyIsThatOfThePaper) {
  const DeformationProblem problem(graph_, constraints_);
  DeformationGraph moved = graph_;
  problem.set_unknowns(random_unknowns(problem, 0.01), moved);
  double rotation = 0, regularity = 0, cameras = 0;
  for (const DeformationNode& node : moved.nodes)
    rotation += (node.R.transpose() * node.R - Eigen::Matrix3d::Identity()).squaredNorm();
  for (const auto& [l, k] : moved.edges) {
    const DeformationNode &a = moved.nodes[static_cast<size_t>(l)], &b = moved.nodes[static_cast<size_t>(k)];
    regularity += (a.moved(b.g_odom) - b.g_odom - b.t).squaredNorm();
  }
  for (const PointConstraint& constraint : constraints_) {
    if (constraint.is_surface) continue;
    const VertexBlend blend = blend_at(moved, constraint.p_odom, constraint.pose_sequence);
    Eigen::Vector3d p = Eigen::Vector3d::Zero();
    for (size_t i = 0; i < 4; ++i)
      p += blend.weight[i] * moved.nodes[static_cast<size_t>(blend.node[i])].moved(constraint.p_odom);
    cameras += (p - constraint.p_world).squaredNorm();
  }
  const Eigen::VectorXd x = problem.unknowns_of(moved);
  const DeformationEnergy energy = problem.energy(x);
  EXPECT_NEAR(energy.rotation, rotation, 1e-9);
  EXPECT_NEAR(energy.regularity, 10 * regularity, 1e-9);
  EXPECT_NEAR(energy.cameras, 100 * cameras, 1e-9);
  EXPECT_GT(energy.surface, 0);
  EXPECT_NEAR(problem.linearise(x).residuals.squaredNorm(), energy.total(), 1e-9)
      << "no residual is beyond Huber's bound here";
}

TEST_F(DeformationProblemTest, FarSurfaceConstraintsPullWithConstantForce) {
  const auto force = [&](double distance_m, bool is_surface) {
    const Eigen::Vector3d p = graph_.nodes[3].g_odom;
    const std::vector<PointConstraint> one = {
        {p, graph_.nodes[3].pose_sequence, p + Eigen::Vector3d(distance_m, 0, 0), is_surface}};
    const DeformationProblem problem(graph_, one);
    const auto [residuals, J] = problem.linearise(problem.unknowns_of(graph_));
    return (J.transpose() * residuals).norm();
  };
  EXPECT_NEAR(force(0.04, true), force(0.04, false), 1e-12);
  EXPECT_NEAR(force(1.0, true), force(graph_.config.huber_m, true), 1e-12);
  EXPECT_NEAR(force(1.0, false), 20 * force(graph_.config.huber_m, true), 1e-9);
}

TEST_F(DeformationProblemTest, LeavesOutConstraintsThatAreNotFinite) {
  constraints_[2].p_odom.x() = test::kNan;
  constraints_[5].p_world.z() = std::numeric_limits<double>::infinity();
  EXPECT_EQ(DeformationProblem(graph_, constraints_).constraints(), 18);
}

}  // namespace
}  // namespace kt
