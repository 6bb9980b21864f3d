// Residuals and analytic Jacobians of observations.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/refinement/observation_cost.h"

#include "offboard/pose_graph/edge_costs.h"

namespace kt {

bool ObservationModel::residual(const Observation& seen, const Eigen::Vector3d& p, const Vector6d& velocity,
                                const CalibrationChange& change, Eigen::Vector3d* r,
                                Eigen::Matrix3d* by_point, Eigen::Matrix<double, 3, 4>* by_change) const {
  // A point at rest moves through the frame of a camera that moves.
  const Eigen::Vector3d flow = -velocity.head<3>().cross(p) - velocity.tail<3>();
  const Eigen::Vector3d c = T_colour_depth * (p + change.colour_delay_s * flow);
  constexpr double kNearest_m = 0.05;
  if (c.z() < kNearest_m || p.z() < kNearest_m) return false;
  const double f = 1 + change.focal, x = c.x() / c.z(), y = c.y() / c.z();
  *r << (f * fx * x + cx + change.centre_px.x() - seen.pixel.x()) / seen.sigma_px,
      (f * fy * y + cy + change.centre_px.y() - seen.pixel.y()) / seen.sigma_px,
      (p.z() - seen.p_camera.z()) / seen.sigma_z;
  if (!by_point) return true;
  Eigen::Matrix<double, 2, 3> by_c;
  by_c << f * fx / c.z(), 0, -f * fx * x / c.z(), 0, f * fy / c.z(), -f * fy * y / c.z();
  by_c /= seen.sigma_px;
  const Eigen::Matrix3d moved =
      T_colour_depth.linear() *
      (Eigen::Matrix3d::Identity() - change.colour_delay_s * skew(Eigen::Vector3d(velocity.head<3>())));
  by_point->topRows<2>() = by_c * moved;
  by_point->row(2) << 0, 0, 1 / seen.sigma_z;
  by_change->setZero();
  by_change->topLeftCorner<2, 1>() << fx * x / seen.sigma_px, fy * y / seen.sigma_px;
  (*by_change)(0, 1) = (*by_change)(1, 2) = 1 / seen.sigma_px;
  by_change->topRightCorner<2, 1>() = by_c * (T_colour_depth.linear() * flow);
  return true;
}

ObservationCost::ObservationCost(const ObservationModel& model, const Observation& seen,
                                 const Vector6d& velocity, double scale)
    : model_(model), seen_(seen), velocity_(velocity), scale_(scale) {
  set_num_residuals(3);
  *mutable_parameter_block_sizes() = {kPoseParameters, 3, 3, 1};
}

bool ObservationCost::Evaluate(double const* const* parameters, double* residuals, double** jacobians) const {
  const Pose T_camera_world = pose_of_parameters(parameters[0]).inverse(Eigen::Isometry);
  const Eigen::Vector3d p_world = Eigen::Map<const Eigen::Vector3d>(parameters[1]);
  const CalibrationChange change{parameters[2][0], {parameters[2][1], parameters[2][2]}, parameters[3][0]};
  Eigen::Vector3d r;
  Eigen::Matrix3d by_point;
  Eigen::Matrix<double, 3, 4> by_change;
  if (!model_.residual(seen_, T_camera_world * p_world, velocity_, change, &r, &by_point, &by_change))
    return false;
  Eigen::Map<Eigen::Vector3d>{residuals} = scale_ * r;
  if (!jacobians) return true;
  const Eigen::Matrix3d by_world = scale_ * by_point * T_camera_world.linear();
  if (jacobians[0]) {
    // T^-1 exp(-xi) p = T^-1 (p - w x p - v).
    Eigen::Map<Eigen::Matrix<double, 3, kPoseParameters, Eigen::RowMajor>> jacobian(jacobians[0]);
    jacobian.setZero();
    jacobian.leftCols<3>() = by_world * skew(p_world);
    jacobian.middleCols<3>(3) = -by_world;
  }
  if (jacobians[1]) Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>{jacobians[1]} = by_world;
  if (jacobians[2])
    Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>{jacobians[2]} = scale_ * by_change.leftCols<3>();
  if (jacobians[3]) Eigen::Map<Eigen::Vector3d>{jacobians[3]} = scale_ * by_change.col(3);
  return true;
}

}  // namespace kt
