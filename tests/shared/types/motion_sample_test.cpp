// Motion of a body, seen from its camera.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/types/motion_sample.h"

#include <gtest/gtest.h>

namespace kt {
namespace {

Pose mount() { return exp_se3((Vector6d() << 0.1, -0.4, 1.2, 0.3, -0.1, 0.8).finished()); }

TEST(OfCamera, PoseAndVelocityOfABodyAgree) {
  const Pose T_body_camera = mount(), T_odom_body = exp_se3((Vector6d() << 0, 0, 0.7, 3, -2, 0).finished());
  MotionSample body;
  body.of = MotionSample::Of::kBody;
  body.velocity << 0.1, -0.2, 0.6, 0.8, 0.1, -0.05;
  body.T_prior = T_odom_body;
  const MotionSample camera = of_camera(body, T_body_camera);
  EXPECT_EQ(camera.of, MotionSample::Of::kCamera);
  EXPECT_TRUE(camera.T_prior.isApprox(T_odom_body * T_body_camera));
  // A moment later.
  body.T_prior = T_odom_body * exp_se3(0.02 * body.velocity);
  const Pose T_later = of_camera(body, T_body_camera).T_prior;
  EXPECT_TRUE(T_later.isApprox(camera.T_prior * exp_se3(0.02 * camera.velocity), 1e-12));
}

TEST(OfCamera, ThatOfACameraStays) {
  MotionSample sample;
  sample.T_prior.translation() = Eigen::Vector3d(1, 2, 3);
  sample.velocity << 1, 2, 3, 4, 5, 6;
  const MotionSample same = of_camera(sample, mount());
  EXPECT_EQ(same.T_prior.matrix(), sample.T_prior.matrix());
  EXPECT_EQ(same.velocity, sample.velocity);
}

}  // namespace
}  // namespace kt
