// What a chain of edges keeps of the frames' own errors, and what the model drifts.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/tracking/edge_information.h"

#include <Eigen/Cholesky>

namespace kt {
namespace {

// A frame is placed against the model, so most of its error is its own, and the next edge takes it back: of a
// chain of edges this share of their variances lasts. Beside it the model drifts as it grows: variance per
// radian turned (rad^2) and per metre gone (m^2). Calibrated on synthetic missions, docs/tracking.md.
constexpr double kLastingShare = 1.0 / 1000, kDriftPerTurn = 3e-8, kDriftPerMove = 3e-7;

// Where nothing is measured the motion is guessed, to so much (rad/s, m/s).
constexpr double kGuessedTurn = 0.2, kGuessedMove = 0.1;

}  // namespace

Matrix6d edge_information(const Matrix6d& measured, const Matrix6d& sensed, const Pose& T_last_current,
                          double dt_s) {
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
  Matrix6d information = measured / kLastingShare;
  information.diagonal() += both(1 / (turn * turn), 1 / (move * move));
  information += sensed;
  Matrix6d covariance = inverse(information);
  covariance.diagonal() += both(kDriftPerTurn * rotation_angle(T_last_current),
                                kDriftPerMove * T_last_current.translation().norm());
  return inverse(covariance);
}

}  // namespace kt
