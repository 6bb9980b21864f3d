// Information of made edges.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "shared/geometry/se3.h"

namespace kt::test {

/// Independent, with these standard deviations about and along every axis.
inline Matrix6d information_of(double sigma_rad, double sigma_m) {
  Vector6d sigmas;
  sigmas << Eigen::Vector3d::Constant(sigma_rad), Eigen::Vector3d::Constant(sigma_m);
  return sigmas.cwiseAbs2().cwiseInverse().asDiagonal();
}

}  // namespace kt::test
