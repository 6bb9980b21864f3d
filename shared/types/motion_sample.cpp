// From the body of a robot to its camera.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/types/motion_sample.h"

namespace kt {

MotionSample of_camera(const MotionSample& sample, const Pose& T_body_camera) {
  if (sample.of == MotionSample::Of::kCamera) return sample;
  MotionSample result = sample;
  result.of = MotionSample::Of::kCamera;
  result.T_prior = sample.T_prior * T_body_camera;
  result.velocity = adjoint(T_body_camera.inverse(Eigen::Isometry)) * sample.velocity;
  return result;
}

}  // namespace kt
