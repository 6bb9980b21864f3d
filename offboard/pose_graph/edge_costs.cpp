// Residuals and analytic Jacobians of pose graph edges.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/pose_graph/edge_costs.h"

#include <Eigen/Cholesky>
#include <cmath>

namespace kt {
namespace {

/// Coefficients of Barfoot's Q, with series where the closed forms cancel.
struct CouplingCoefficients {
  double a, b, c;
};

CouplingCoefficients coupling_coefficients(double squared_angle) {
  const double x = squared_angle;
  if (x < 0.04) {
    const double a = 1.0 / 6 - x / 120 + x * x / 5040 - x * x * x / 362880;
    const double b = 1.0 / 24 - x / 720 + x * x / 40320 - x * x * x / 3628800;
    const double c = 1.0 / 120 - x / 2520 + x * x / 120960 - x * x * x / 9979200;
    return {a, b, c};
  }
  const double angle = std::sqrt(x), sine = std::sin(angle), cosine = std::cos(angle);
  const double a = (angle - sine) / (x * angle);
  const double b = (x + 2 * cosine - 2) / (2 * x * x);
  const double c = (2 * angle - 3 * sine + angle * cosine) / (2 * x * x * angle);
  return {a, b, c};
}

/// Both residuals depend on T_i^-1 T_j alone: what moves both ends together changes nothing.
void write_jacobians(const Matrix6d& by_to, double** jacobians) {
  for (int k = 0; k < 2; ++k) {
    if (!jacobians[k]) continue;
    Eigen::Map<Eigen::Matrix<double, 6, kPoseParameters, Eigen::RowMajor>> jacobian(jacobians[k]);
    jacobian.setZero();
    jacobian.leftCols<6>() = k == 0 ? Matrix6d(-by_to) : by_to;
  }
}

Eigen::Matrix3d inverse_left_jacobian_so3(const Eigen::Vector3d& w) {
  const double x = w.squaredNorm();
  double c = 1.0 / 12 + x / 720 + x * x / 30240;
  if (x > 0.01) {
    const double angle = std::sqrt(x);
    c = (1 - angle / 2 * std::sin(angle) / (1 - std::cos(angle))) / x;
  }
  const Eigen::Matrix3d K = skew(w);
  return Eigen::Matrix3d::Identity() - 0.5 * K + c * K * K;
}

}  // namespace

void write_parameters(const Pose& T, double* parameters) {
  Eigen::Map<Eigen::Matrix3d>{parameters} = T.linear();
  Eigen::Map<Eigen::Vector3d>{parameters + 9} = T.translation();
}

Pose pose_of_parameters(const double* parameters) {
  Pose T = Pose::Identity();
  T.linear() = Eigen::Map<const Eigen::Matrix3d>(parameters);
  T.translation() = Eigen::Map<const Eigen::Vector3d>(parameters + 9);
  return T;
}

Matrix6d inverse_left_jacobian(const Vector6d& xi) {
  const Eigen::Vector3d w = xi.head<3>(), v = xi.tail<3>();
  const Eigen::Matrix3d W = skew(w), V = skew(v), J = inverse_left_jacobian_so3(w);
  const auto [a, b, c] = coupling_coefficients(w.squaredNorm());
  const Eigen::Matrix3d WV = W * V, VW = V * W, WVW = WV * W;
  const Eigen::Matrix3d Q =
      0.5 * V + a * (WV + VW + WVW) + b * (W * WV + VW * W - 3 * WVW) + c * (WVW * W + W * WVW);
  Matrix6d result = Matrix6d::Zero();
  result.topLeftCorner<3, 3>() = result.bottomRightCorner<3, 3>() = J;
  result.bottomLeftCorner<3, 3>() = -J * Q * J;
  return result;
}

Matrix6d whitening(const Matrix6d& information) {
  if (information.isZero(0)) return Matrix6d::Zero();
  return information.llt().matrixU();
}

bool LeftPerturbation::Plus(const double* x, const double* delta, double* x_plus_delta) const {
  const Vector6d xi = Eigen::Map<const Vector6d>(delta);
  write_parameters(exp_se3(xi) * pose_of_parameters(x), x_plus_delta);
  return true;
}

bool LeftPerturbation::PlusJacobian(const double*, double* jacobian) const {
  Eigen::Map<Eigen::Matrix<double, kPoseParameters, 6, Eigen::RowMajor>>{jacobian}.setIdentity();
  return true;
}

bool LeftPerturbation::Minus(const double* y, const double* x, double* y_minus_x) const {
  const Pose T = pose_of_parameters(y) * pose_of_parameters(x).inverse(Eigen::Isometry);
  Eigen::Map<Vector6d>{y_minus_x} = log_se3(T);
  return true;
}

bool LeftPerturbation::MinusJacobian(const double*, double* jacobian) const {
  Eigen::Map<Eigen::Matrix<double, 6, kPoseParameters, Eigen::RowMajor>>{jacobian}.setIdentity();
  return true;
}

Se3Cost::Se3Cost(const IndexedEdge& edge, double weight)
    : T_to_from_(edge.T_from_to.inverse(Eigen::Isometry)),
      whitening_(std::sqrt(weight) * whitening(edge.information)) {
  set_num_residuals(6);
  *mutable_parameter_block_sizes() = {kPoseParameters, kPoseParameters};
}

bool Se3Cost::Evaluate(double const* const* poses, double* residuals, double** jacobians) const {
  const Pose T_from_world = pose_of_parameters(poses[0]).inverse(Eigen::Isometry);
  const Vector6d e = log_se3(T_from_world * pose_of_parameters(poses[1]) * T_to_from_);
  Eigen::Map<Vector6d>{residuals} = whitening_ * e;
  if (!jacobians) return true;
  // T_i^-1 exp(xi_j) T_j = exp(Ad(T_i^-1) xi_j) T_i^-1 T_j, and the same with the other sign for xi_i.
  const Matrix6d by_to = whitening_ * inverse_left_jacobian(e) * adjoint(T_from_world);
  write_jacobians(by_to, jacobians);
  return true;
}

ChordalCost::ChordalCost(const IndexedEdge& edge, double weight) : T_from_to_(edge.T_from_to) {
  sqrt_8_kappa_ = std::sqrt(8 * weight * edge.chordal.kappa);
  sqrt_tau_ = std::sqrt(weight * edge.chordal.tau);
  set_num_residuals(6);
  *mutable_parameter_block_sizes() = {kPoseParameters, kPoseParameters};
}

bool ChordalCost::Evaluate(double const* const* poses, double* residuals, double** jacobians) const {
  const Pose T_i_world = pose_of_parameters(poses[0]).inverse(Eigen::Isometry);
  const Pose T_world_j = pose_of_parameters(poses[1]);
  const Pose T_i_j = T_i_world * T_world_j;
  Eigen::Quaterniond q(T_i_j.linear() * T_from_to_.linear().transpose());
  q.normalize();
  if (q.w() < 0) q.coeffs() = -q.coeffs();
  Eigen::Map<Eigen::Vector3d>{residuals} = sqrt_8_kappa_ * q.vec();
  Eigen::Map<Eigen::Vector3d>{residuals + 3} = sqrt_tau_ * (T_i_j.translation() - T_from_to_.translation());
  if (!jacobians) return true;
  // A left perturbation w, v of j multiplies q from the left by (1, R_i^T w / 2) and moves t_j by w x t_j +
  // v.
  Matrix6d by_to = Matrix6d::Zero();
  by_to.topLeftCorner<3, 3>() =
      sqrt_8_kappa_ / 2 * (q.w() * Eigen::Matrix3d::Identity() - skew(q.vec())) * T_i_world.linear();
  by_to.bottomLeftCorner<3, 3>() = -sqrt_tau_ * T_i_world.linear() * skew(T_world_j.translation());
  by_to.bottomRightCorner<3, 3>() = sqrt_tau_ * T_i_world.linear();
  write_jacobians(by_to, jacobians);
  return true;
}

}  // namespace kt
