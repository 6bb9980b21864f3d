// Properties of SE(3): group axioms, exponential map, adjoint, left Jacobian.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/geometry/se3.h"

#include <limits>
#include <numbers>

#include "gtest/gtest.h"

#include "shared/core/rng.h"

namespace kt {
namespace {

constexpr double kPi = std::numbers::pi;

Eigen::Vector3d random_unit(uint64_t i) {
  return Eigen::Vector3d(random_normal(1, 0, i), random_normal(1, 1, i), random_normal(1, 2, i)).normalized();
}

Vector6d tangent(const Eigen::Vector3d& axis, double angle, const Eigen::Vector3d& translation) {
  Vector6d xi;
  xi << angle * axis, translation;
  return xi;
}

// Rotations from none to half a turn, the borders of every branch among them.
std::vector<Vector6d> tangents() {
  std::vector<Vector6d> all{Vector6d::Zero()};
  uint64_t i = 0;
  for (const double angle : {0.0, 1e-12, 1e-9, 1e-6, 0.99e-4, 1.01e-4, 1e-3, 0.1, 1.0, 2.0, 3.0, kPi - 1e-3,
                             kPi - 1e-6, kPi - 1e-9}) {
    for (int repeat = 0; repeat < 5; ++repeat, ++i)
      all.push_back(tangent(random_unit(i), angle, 3 * random_unit(1000 + i)));
  }
  return all;
}

Eigen::Matrix4d hat(const Vector6d& xi) {
  Eigen::Matrix4d m = Eigen::Matrix4d::Zero();
  m.topLeftCorner<3, 3>() = skew(xi.head<3>());
  m.topRightCorner<3, 1>() = xi.tail<3>();
  return m;
}

// Matrix exponential by its series: slow, and no closed form in it.
Eigen::Matrix4d series_exp(const Vector6d& xi) {
  Eigen::Matrix4d sum = Eigen::Matrix4d::Identity(), term = sum;
  for (int k = 1; k < 60; ++k) {
    term = term * hat(xi) / k;
    sum += term;
  }
  return sum;
}

TEST(Se3, SkewIsTheCrossProduct) {
  const Eigen::Vector3d a(1, -2, 3), b(0.5, 4, -1);
  EXPECT_LT((skew(a) * b - a.cross(b)).norm(), 1e-15);
}

TEST(Se3, ExpIsTheMatrixExponential) {
  for (const Vector6d& xi : tangents()) {
    EXPECT_LT((exp_se3(xi).matrix() - series_exp(xi)).cwiseAbs().maxCoeff(), 1e-11) << xi.transpose();
    EXPECT_LT((exp_so3(xi.head<3>()) - exp_se3(xi).linear()).cwiseAbs().maxCoeff(), 1e-15);
  }
}

TEST(Se3, ExpIsARigidTransform) {
  for (const Vector6d& xi : tangents()) EXPECT_TRUE(is_valid_pose(exp_se3(xi), 1e-12)) << xi.transpose();
}

TEST(Se3, LogInvertsExp) {
  for (const Vector6d& xi : tangents()) EXPECT_LT((log_se3(exp_se3(xi)) - xi).norm(), 2e-8) << xi.transpose();
}

TEST(Se3, LogOfSmallTangentsIsExact) {
  for (const Vector6d& xi : tangents()) {
    if (xi.head<3>().norm() > 1) continue;
    EXPECT_LT((log_se3(exp_se3(xi)) - xi).norm(), 1e-11) << xi.transpose();
  }
}

TEST(Se3, ExpInvertsLogAtHalfATurn) {
  for (uint64_t i = 0; i < 20; ++i) {
    Pose T = Pose::Identity();
    const Eigen::Vector3d axis =
        i < 3 ? Eigen::Vector3d(Eigen::Vector3d::Unit(static_cast<int>(i))) : random_unit(i);
    T.linear() = 2 * axis * axis.transpose() - Eigen::Matrix3d::Identity();  // exactly pi about `axis`
    T.translation() = random_unit(100 + i);
    const Vector6d xi = log_se3(T);
    EXPECT_NEAR(xi.head<3>().norm(), kPi, 1e-12);
    EXPECT_LT((exp_se3(xi).matrix() - T.matrix()).cwiseAbs().maxCoeff(), 1e-12);
  }
}

TEST(Se3, LogAngleNeverExceedsHalfATurn) {
  EXPECT_NEAR(log_so3(exp_so3({0, 0, 1.5 * kPi})).z(), -0.5 * kPi, 1e-12);
  EXPECT_NEAR(log_so3(exp_so3({2 * kPi + 0.1, 0, 0})).x(), 0.1, 1e-12);
}

TEST(Se3, InverseOfExpIsExpOfMinus) {
  for (const Vector6d& xi : tangents()) {
    EXPECT_LT(((exp_se3(xi) * exp_se3(-xi)).matrix() - Eigen::Matrix4d::Identity()).cwiseAbs().maxCoeff(),
              1e-11);
  }
}

TEST(Se3, AdjointMovesATangentThroughATransform) {
  for (uint64_t i = 0; i < 20; ++i) {
    const Pose T = exp_se3(tangent(random_unit(i), 0.15 * static_cast<double>(i), 2 * random_unit(50 + i)));
    const Vector6d xi = tangent(random_unit(200 + i), 0.7, random_unit(300 + i));
    const Pose direct = T * exp_se3(xi) * T.inverse();
    const Pose moved = exp_se3(adjoint(T) * xi);
    EXPECT_LT((direct.matrix() - moved.matrix()).cwiseAbs().maxCoeff(), 1e-12);
  }
}

TEST(Se3, AdjointIsAHomomorphism) {
  const Pose A = exp_se3(tangent(random_unit(1), 1.2, random_unit(2))),
             B = exp_se3(tangent(random_unit(3), 2.1, random_unit(4)));
  EXPECT_LT((adjoint(A * B) - adjoint(A) * adjoint(B)).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_LT((adjoint(A.inverse()) - adjoint(A).inverse()).cwiseAbs().maxCoeff(), 1e-12);
}

// A small change of T_b_c weighs the same before and after, seen from either side.
TEST(Se3, TransportedInformationWeighsTheSameChangeAlike) {
  for (uint64_t i = 0; i < 20; ++i) {
    const Pose T_a_b =
                   exp_se3(tangent(random_unit(i), 0.15 * static_cast<double>(i), 2 * random_unit(50 + i))),
               T_b_c = exp_se3(tangent(random_unit(70 + i), 1.1, random_unit(90 + i)));
    const Pose T_a_c = T_a_b * T_b_c;
    Matrix6d root;
    for (int k = 0; k < 36; ++k) root(k) = random_normal(2, i, static_cast<uint64_t>(k));
    const Matrix6d information = root * root.transpose();
    const Matrix6d moved = transported(information, T_a_b);
    EXPECT_EQ(moved, moved.transpose());
    for (uint64_t k = 0; k < 6; ++k) {
      const Vector6d xi_b = tangent(random_unit(200 + 6 * i + k), 1e-3, 1e-3 * random_unit(400 + 6 * i + k));
      const Vector6d xi_a = log_se3(T_a_b * exp_se3(xi_b) * T_b_c * T_a_c.inverse());
      const double expected = xi_a.dot(information * xi_a);
      EXPECT_NEAR(xi_b.dot(moved * xi_b), expected, 1e-8 * expected);
    }
    EXPECT_LT((transported(moved, T_a_b.inverse()) - information).norm(), 1e-11 * moved.norm());
  }
}

// d(exp(xi) T p) / dxi at 0 is [-[T p]x, I]: what every solver here builds on.
TEST(Se3, LeftPerturbationHasTheStatedJacobian) {
  constexpr double kStep = 1e-6;
  for (uint64_t i = 0; i < 20; ++i) {
    const Pose T = exp_se3(tangent(random_unit(i), 2.0, random_unit(20 + i)));
    const Eigen::Vector3d p = 3 * random_unit(40 + i);
    Eigen::Matrix<double, 3, 6> stated, numeric;
    stated << -skew(T * p), Eigen::Matrix3d::Identity();
    for (int k = 0; k < 6; ++k) {
      const Vector6d step = kStep * Vector6d::Unit(k);
      numeric.col(k) = (exp_se3(step) * T * p - exp_se3(-step) * T * p) / (2 * kStep);
    }
    EXPECT_LT((stated - numeric).cwiseAbs().maxCoeff(), 1e-8);
  }
}

TEST(Se3, OrthonormalisedStopsDrift) {
  const Pose step = exp_se3(tangent(random_unit(5), 0.3, {0.01, 0, 0}));
  Pose drifting = step, kept = step;
  drifting.linear() *= 1 + 1e-9;
  for (int i = 0; i < 1000; ++i) kept = orthonormalised(kept * drifting);
  EXPECT_TRUE(is_valid_pose(kept, 1e-14));
  const Pose once = orthonormalised(drifting);
  EXPECT_LT((once.linear() - step.linear()).cwiseAbs().maxCoeff(), 1e-9);  // moves no farther than the drift
  EXPECT_EQ(once.translation(), drifting.translation());
}

TEST(Se3, RotationAngleIsThatOfTheLog) {
  for (const double angle : {0.0, 1e-7, 0.5, 3.1}) {
    EXPECT_NEAR(rotation_angle(exp_se3(tangent(random_unit(9), angle, {5, 5, 5}))), angle, 1e-9);
  }
}

TEST(Se3, MovementIsMetresPlusRadians) {
  Pose T = Pose::Identity();
  EXPECT_EQ(movement(T), 0);
  T.translation() = Eigen::Vector3d(0, 0.3, -0.4);
  T.linear() = exp_so3(Eigen::Vector3d(0, 0.25, 0));
  EXPECT_NEAR(movement(T), 0.75, 1e-12);
}

TEST(Se3, OneOpenDirectionLeavesAMotionUnconstrained) {
  Matrix6d information = 1e4 * Matrix6d::Identity();  // 0.01 rad and 0.01 m
  EXPECT_TRUE(is_constrained(information, 0.011, 0.011));
  EXPECT_FALSE(is_constrained(information, 0.009, 0.011));
  EXPECT_FALSE(is_constrained(information, 0.011, 0.009));
  information(4, 4) = 0;
  EXPECT_FALSE(is_constrained(information, 1, 1));
}

TEST(Se3, InvalidPosesAreSeen) {
  EXPECT_TRUE(is_valid_pose(Pose::Identity()));
  Pose scaled = Pose::Identity(), mirrored = scaled, unknown = scaled, far = scaled;
  scaled.linear() *= 1.01;
  mirrored.linear()(0, 0) = -1;
  unknown.translation().y() = std::numeric_limits<double>::quiet_NaN();
  far.translation().z() = std::numeric_limits<double>::infinity();
  for (const Pose& T : {scaled, mirrored, unknown, far}) EXPECT_FALSE(is_valid_pose(T)) << T.matrix();
}

TEST(Se3, KernelCopyMapsPointsAlike) {
  const Pose T = exp_se3(tangent(random_unit(3), 1.0, {1, -2, 3}));
  const Rigid3f copy = to_rigid3f(T);
  for (uint64_t i = 0; i < 20; ++i) {
    const Eigen::Vector3d p = 4 * random_unit(i), expected = T * p;
    const Vec3f q =
        copy * Vec3f{static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z())};
    EXPECT_NEAR(q.x, expected.x(), 2e-6);
    EXPECT_NEAR(q.y, expected.y(), 2e-6);
    EXPECT_NEAR(q.z, expected.z(), 2e-6);
  }
}

}  // namespace
}  // namespace kt
