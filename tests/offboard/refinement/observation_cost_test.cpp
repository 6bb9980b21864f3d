// Predictions of features, and their derivatives against differences.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/refinement/observation_cost.h"

#include <array>
#include <gtest/gtest.h>

#include "offboard/pose_graph/edge_costs.h"

namespace kt {
namespace {

Calibration rig() {
  Calibration calibration;
  calibration.colour = {640, 480, 520, 515, 321, 239, {}};
  calibration.T_colour_depth = exp_se3((Vector6d() << 0.01, -0.02, 0.005, -0.025, 0.001, 0.002).finished());
  return calibration;
}

const Vector6d kVelocity = (Vector6d() << 0.4, -0.3, 0.2, 0.3, -0.1, 0.2).finished();

TEST(ObservationModel, IsZeroWhereThePointIsAndSeesDelaysOnlyInMotion) {
  const Calibration calibration = rig();
  const ObservationModel model(calibration);
  Observation seen;
  seen.p_camera = {0.3, -0.2, 2};
  const Eigen::Vector3d c = calibration.T_colour_depth * seen.p_camera;
  seen.pixel = {520 * c.x() / c.z() + 321, 515 * c.y() / c.z() + 239};
  Eigen::Vector3d r;
  ASSERT_TRUE(model.residual(seen, seen.p_camera, kVelocity, {}, &r));
  EXPECT_LT(r.norm(), 1e-9);
  ASSERT_TRUE(model.residual(seen, seen.p_camera, Vector6d::Zero(), {.colour_delay_s = 0.01}, &r));
  EXPECT_LT(r.norm(), 1e-9);
  // 0.3 rad/s to the left turns everything to the right: 520 px/rad * 0.3 rad/s * 0.01 s, and a little more
  // off the centre.
  const Vector6d turning = (Vector6d() << 0, -0.3, 0, 0, 0, 0).finished();
  ASSERT_TRUE(model.residual(seen, seen.p_camera, turning, {.colour_delay_s = 0.01}, &r));
  EXPECT_NEAR(r.x(), 1.56, 0.06);
  EXPECT_FALSE(model.residual(seen, {0, 0, -1}, kVelocity, {}, &r));
}

TEST(ObservationCost, JacobiansAreThoseOfDifferences) {
  const ObservationModel model(rig());
  const Observation seen{
      .keyframe = 0, .pixel = {400, 200}, .p_camera = {0.3, -0.2, 2.1}, .sigma_px = 0.7, .sigma_z = 0.02};
  const ObservationCost cost(model, seen, kVelocity, 1.3);
  const Pose T = exp_se3((Vector6d() << 0.2, -0.4, 0.1, 1, -2, 0.5).finished());
  const Eigen::Vector3d p = T * Eigen::Vector3d(0.31, -0.22, 2.05);
  std::array<double, kPoseParameters> pose;
  write_parameters(T, pose.data());
  std::array<double, 3> point{p.x(), p.y(), p.z()}, intrinsics{0.01, 1.5, -2};
  double delay = 0.012;
  const std::array<double*, 4> parameters{pose.data(), point.data(), intrinsics.data(), &delay};
  std::array<double, 3 * kPoseParameters> by_pose;
  std::array<double, 9> by_point, by_intrinsics;
  std::array<double, 3> by_delay, residuals;
  const std::array<double*, 4> jacobians{by_pose.data(), by_point.data(), by_intrinsics.data(),
                                         by_delay.data()};
  const std::array<const double*, 4> inputs{pose.data(), point.data(), intrinsics.data(), &delay};
  std::array<double*, 4> outputs = jacobians;
  ASSERT_TRUE(cost.Evaluate(inputs.data(), residuals.data(), outputs.data()));

  constexpr double kStep = 1e-6;
  const auto expect_derivative = [&](auto&& move, const double* column, int stride) {
    std::array<double, 3> up, down;
    move(kStep);
    ASSERT_TRUE(cost.Evaluate(inputs.data(), up.data(), nullptr));
    move(-kStep);
    ASSERT_TRUE(cost.Evaluate(inputs.data(), down.data(), nullptr));
    move(0);
    for (size_t row = 0; row < 3; ++row)
      EXPECT_NEAR(column[static_cast<size_t>(stride) * row], (up[row] - down[row]) / (2 * kStep), 2e-4);
  };
  for (int k = 0; k < 6; ++k) {
    const auto move = [&](double step) {
      write_parameters(exp_se3(Vector6d(step * Vector6d::Unit(k))) * T, pose.data());
    };
    expect_derivative(move, by_pose.data() + k, kPoseParameters);
  }
  const auto expect_of_block = [&](size_t block, int size) {
    for (int k = 0; k < size; ++k) {
      double& value = parameters[block][k];
      const double before = value;
      expect_derivative([&](double step) { value = before + step; }, jacobians[block] + k, size);
    }
  };
  expect_of_block(1, 3);
  expect_of_block(2, 3);
  expect_of_block(3, 1);
}

}  // namespace
}  // namespace kt
