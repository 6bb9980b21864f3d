// Rigid transforms in double precision, their exponential map, and the conventions every solver here follows.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "shared/core/vec.h"

namespace kt {

/// `T_a_b` maps points of frame b to frame a: p_a = T_a_b * p_b.
using Pose = Eigen::Isometry3d;

/// Tangent vector [rotation (rad); translation (m)]. Perturbations act on the left: T' = exp(xi) * T, so
/// rotation and translation are expressed in the frame that T maps to. Information matrices follow the same
/// order and side.
using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

Eigen::Matrix3d skew(const Eigen::Vector3d& v);

/// Rotation of `rotation_vector` (rad); Rodrigues' formula, exact down to zero.
Eigen::Matrix3d exp_so3(const Eigen::Vector3d& rotation_vector);
/// Rotation vector of R (rad), length in [0, pi].
Eigen::Vector3d log_so3(const Eigen::Matrix3d& R);

/// SE(3) exponential with the full left Jacobian on translation.
Pose exp_se3(const Vector6d& xi);
Vector6d log_se3(const Pose& T);

/// Adjoint in the order [rotation; translation]: T exp(xi) T^-1 = exp(Ad_T xi).
Matrix6d adjoint(const Pose& T);

/// Information of the left perturbation of T_b_c where `information` is that of T_a_c, for the same change:
/// xi_a = Ad(T_a_b) xi_b.
Matrix6d transported(const Matrix6d& information, const Pose& T_a_b);

/// T with its rotation projected back to SO(3); keeps long products orthonormal.
Pose orthonormalised(const Pose& T);

/// Rotation angle of T in radians.
double rotation_angle(const Pose& T);

/// Whether a motion of this information is known to these standard deviations about and along every axis.
bool is_constrained(const Matrix6d& information, double max_rotation_sigma_rad,
                    double max_translation_sigma_m);

/// How much a camera moved: metres plus radians (the paper's eq. 2).
double movement(const Pose& T);

/// Whether every entry is finite and the rotation is orthonormal to `tolerance`.
bool is_valid_pose(const Pose& T, double tolerance = 1e-3);

inline Eigen::Vector3d to_eigen(Vec3f v) { return Eigen::Vector3f(v.x, v.y, v.z).cast<double>(); }
inline Vec3f to_vec3f(const Eigen::Vector3d& v) {
  return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
}

/// The single-precision copy that kernels take.
Rigid3f to_rigid3f(const Pose& T);

}  // namespace kt
