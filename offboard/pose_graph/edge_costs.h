// The two residuals of an edge as Ceres cost functions, with their Jacobians and the manifold that goes with
// them.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ceres/cost_function.h>
#include <ceres/manifold.h>

#include "offboard/pose_graph/indexed_graph.h"

namespace kt {

/// A pose as Ceres sees it: the columns of R, then t. Only plain doubles cross to Ceres, whose library has
/// been compiled with another Eigen configuration.
inline constexpr int kPoseParameters = 12;
void write_parameters(const Pose& T, double* parameters);
Pose pose_of_parameters(const double* parameters);

/// Left Jacobian of SE(3), inverted: log(exp(delta) exp(xi)) = xi + J^-1 delta to first order (Barfoot 2017,
/// eq. 7.86 and 7.95, in the order [rotation; translation]).
Matrix6d inverse_left_jacobian(const Vector6d& xi);

/// W with W^T W = `information`, so that |W e|^2 = e^T information e: the *upper* Cholesky factor. Zero for
/// zero information.
Matrix6d whitening(const Matrix6d& information);

/// T' = exp(xi) T. The Jacobians of the costs below are given by xi in the first six columns, zeros in the
/// others: PlusJacobian is [I; 0], so that Ceres ends up with d cost / d xi.
class LeftPerturbation : public ceres::Manifold {
 public:
  int AmbientSize() const override { return kPoseParameters; }
  int TangentSize() const override { return 6; }
  bool Plus(const double* x, const double* delta, double* x_plus_delta) const override;
  bool PlusJacobian(const double* x, double* jacobian) const override;
  bool Minus(const double* y, const double* x, double* y_minus_x) const override;
  bool MinusJacobian(const double* x, double* jacobian) const override;
};

/// sqrt(weight) W e, 6 rows, e = log(T_i^-1 T_j T_ij^-1): the left perturbation of the measurement that
/// explains the poses, in the frame of i.
class Se3Cost : public ceres::CostFunction {
 public:
  Se3Cost(const IndexedEdge& edge, double weight);
  bool Evaluate(double const* const* poses, double* residuals, double** jacobians) const override;

 private:
  Pose T_to_from_;
  Matrix6d whitening_;
};

/// 6 rows whose squares sum to kappa |R_j - R_i R_ij|_F^2 + tau |t_j - t_i - R_i t_ij|^2: sqrt(8 kappa) times
/// the vector part of the quaternion of R_i^T R_j R_ij^T (|R - I|_F^2 = 8 sin^2(angle / 2)), and sqrt(tau)
/// (R_i^T (t_j - t_i) - t_ij). As differences of matrices and points in the world, the same sum has residuals
/// that turn with the graph: Gauss-Newton takes that for stiffness and needs some ten times the iterations.
class ChordalCost : public ceres::CostFunction {
 public:
  ChordalCost(const IndexedEdge& edge, double weight);
  bool Evaluate(double const* const* poses, double* residuals, double** jacobians) const override;

 private:
  Pose T_from_to_;
  double sqrt_8_kappa_, sqrt_tau_;
};

}  // namespace kt
