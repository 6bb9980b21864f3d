// What a chain of edges keeps of the frames' own errors, and what the model drifts.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/tracking/edge_information.h"

#include <Eigen/Cholesky>

namespace kt {
namespace {

// Of a frame placed against the model most of the error is its own, and the next edge takes it back: of a
// chain of such edges this share of their variances lasts. Beside it the model drifts as it grows: variance
// per radian turned (rad^2) and per metre gone (m^2). Calibrated on synthetic missions, docs/tracking.md.
constexpr double kLastingShare = 1.0 / 2000, kDriftPerTurn = 1.5e-8, kDriftPerMove = 1.5e-7;

// Where nothing is measured the motion is guessed, to so much (rad/s, m/s).
constexpr double kGuessedTurn = 0.2, kGuessedMove = 0.1;

}  // namespace

Matrix6d edge_information(const Matrix6d& measured, const Matrix6d& sensed, const Pose& T_last_current,
                          double dt_s, bool is_against_model) {
  const auto both = [](double rotation, double translation) {
    Vector6d diagonal;
    diagonal << Eigen::Vector3d::Constant(rotation), Eigen::Vector3d::Constant(translation);
    return diagonal;
  };
  const auto inverse = [](const Matrix6d& A) -> Matrix6d {
    const Matrix6d result = A.llt().solve(Matrix6d::Identity());
    return (result + result.transpose()) / 2;
  };
  const double turn = kGuessedTurn * dt_s, move = kGuessedMove * dt_s;
  Matrix6d information = measured / (is_against_model ? kLastingShare : 1);
  information.diagonal() += both(1 / (turn * turn), 1 / (move * move));
  information += sensed;
  Matrix6d covariance = inverse(information);
  covariance.diagonal() += both(kDriftPerTurn * rotation_angle(T_last_current),
                                kDriftPerMove * T_last_current.translation().norm());
  return inverse(covariance);
}

}  // namespace kt
