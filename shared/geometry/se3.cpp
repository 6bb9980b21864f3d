// SE(3) closed forms (Barfoot 2017, ch. 7), with series near zero.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/geometry/se3.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace kt {
namespace {

// sin(t)/t, (1 - cos t)/t^2 and (t - sin t)/t^3 of the rotation angle t.
struct RodriguesCoefficients {
  double a, b, c;
};

RodriguesCoefficients rodrigues_coefficients(double squared_angle) {
  if (squared_angle < 1e-8) {
    return {1 - squared_angle / 6, 0.5 - squared_angle / 24, 1.0 / 6 - squared_angle / 120};
  }
  const double angle = std::sqrt(squared_angle);
  const double sine = std::sin(angle);
  return {sine / angle, (1 - std::cos(angle)) / squared_angle, (angle - sine) / (squared_angle * angle)};
}

}  // namespace

Eigen::Matrix3d skew(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

Eigen::Matrix3d exp_so3(const Eigen::Vector3d& rotation_vector) {
  const auto [a, b, c] = rodrigues_coefficients(rotation_vector.squaredNorm());
  const Eigen::Matrix3d K = skew(rotation_vector);
  return Eigen::Matrix3d::Identity() + a * K + b * K * K;
}

Eigen::Vector3d log_so3(const Eigen::Matrix3d& R) {
  // Through the quaternion: stable at every angle, pi included.
  Eigen::Quaterniond q(R);
  q.normalize();
  if (q.w() < 0) q.coeffs() = -q.coeffs();
  const double sine = q.vec().norm();
  const double scale = sine < 1e-10 ? 2.0 : 2.0 * std::atan2(sine, q.w()) / sine;
  return scale * q.vec();
}

Pose exp_se3(const Vector6d& xi) {
  const Eigen::Vector3d w = xi.head<3>();
  const auto [a, b, c] = rodrigues_coefficients(w.squaredNorm());
  const Eigen::Matrix3d K = skew(w);
  const Eigen::Matrix3d KK = K * K;
  Pose T = Pose::Identity();
  T.linear() = Eigen::Matrix3d::Identity() + a * K + b * KK;
  T.translation() = (Eigen::Matrix3d::Identity() + b * K + c * KK) * xi.tail<3>();
  return T;
}

Vector6d log_se3(const Pose& T) {
  const Eigen::Vector3d w = log_so3(T.linear());
  const auto [a, b, c] = rodrigues_coefficients(w.squaredNorm());
  const Eigen::Matrix3d K = skew(w);
  const Eigen::Matrix3d V = Eigen::Matrix3d::Identity() + b * K + c * K * K;
  Vector6d xi;
  xi << w, V.partialPivLu().solve(T.translation());
  return xi;
}

Matrix6d adjoint(const Pose& T) {
  Matrix6d ad = Matrix6d::Zero();
  ad.topLeftCorner<3, 3>() = T.linear();
  ad.bottomRightCorner<3, 3>() = T.linear();
  ad.bottomLeftCorner<3, 3>() = skew(T.translation()) * T.linear();
  return ad;
}

Matrix6d transported(const Matrix6d& information, const Pose& T_a_b) {
  const Matrix6d Ad = adjoint(T_a_b);
  const Matrix6d moved = Ad.transpose() * information * Ad;
  return (moved + moved.transpose()) / 2;
}

Pose orthonormalised(const Pose& T) {
  Pose result = Pose::Identity();
  result.linear() = Eigen::Quaterniond(T.linear()).normalized().toRotationMatrix();
  result.translation() = T.translation();
  return result;
}

double rotation_angle(const Pose& T) { return log_so3(T.linear()).norm(); }

bool is_valid_pose(const Pose& T, double tolerance) {
  if (!T.matrix().allFinite()) return false;
  const Eigen::Matrix3d R = T.linear();
  return (R * R.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() < tolerance &&
         R.determinant() > 0;
}

bool is_constrained(const Matrix6d& information, double max_rotation_sigma_rad,
                    double max_translation_sigma_m) {
  const Eigen::LLT<Matrix6d> llt(information);
  if (llt.info() != Eigen::Success) return false;
  const Vector6d variances = llt.solve(Matrix6d::Identity()).diagonal();
  return variances.allFinite() &&
         variances.head<3>().maxCoeff() < max_rotation_sigma_rad * max_rotation_sigma_rad &&
         variances.tail<3>().maxCoeff() < max_translation_sigma_m * max_translation_sigma_m;
}

double movement(const Pose& T) { return T.translation().norm() + rotation_angle(T); }

Rigid3f to_rigid3f(const Pose& T) {
  Rigid3f result;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      result.R.m[3 * row + column] = static_cast<float>(T.linear()(row, column));
    }
  }
  result.t = {static_cast<float>(T.translation().x()), static_cast<float>(T.translation().y()),
              static_cast<float>(T.translation().z())};
  return result;
}

}  // namespace kt
