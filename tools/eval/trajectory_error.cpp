// ATE by Horn's alignment, RPE over fixed spans.
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/eval/trajectory_error.h"

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "shared/core/check.h"
#include "tools/eval/groundtruth.h"

namespace kt {
namespace {

std::vector<int64_t> stamps_of(const Trajectory& trajectory) {
  std::vector<int64_t> stamps_us;
  for (const StampedPose& pose : trajectory) stamps_us.push_back(pose.timestamp_us);
  return stamps_us;
}

/// Indices of the poses by stamp.
std::vector<size_t> order_of(const Trajectory& trajectory) {
  std::vector<size_t> order(trajectory.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) {
    return trajectory[a].timestamp_us < trajectory[b].timestamp_us;
  });
  return order;
}

Trajectory sorted(const Trajectory& trajectory, const std::vector<size_t>& order) {
  Trajectory result;
  for (const size_t i : order) result.push_back(trajectory[i]);
  return result;
}

/// Index of the value closest to `target` in an ascending list; the smaller one of two as close.
template <typename T>
size_t closest(const std::vector<T>& ascending, T target) {
  const auto above = std::lower_bound(ascending.begin(), ascending.end(), target);
  if (above == ascending.begin()) return 0;
  const size_t i = static_cast<size_t>(above - ascending.begin());
  return above != ascending.end() && *above - target < target - ascending[i - 1] ? i : i - 1;
}

/// The rigid T that minimises sum ||model - T data||^2 (Horn 1987, through the SVD of the cross covariance).
Pose align(const std::vector<Eigen::Vector3d>& model, const std::vector<Eigen::Vector3d>& data) {
  Eigen::Vector3d model_mean = Eigen::Vector3d::Zero(), data_mean = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& p : model) model_mean += p / static_cast<double>(model.size());
  for (const Eigen::Vector3d& p : data) data_mean += p / static_cast<double>(data.size());
  Eigen::Matrix3d W = Eigen::Matrix3d::Zero();
  for (size_t i = 0; i < model.size(); ++i) W += (model[i] - model_mean) * (data[i] - data_mean).transpose();
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(W, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Vector3d signs = Eigen::Vector3d::Ones();
  if (svd.matrixU().determinant() * svd.matrixV().determinant() < 0) signs.z() = -1;
  Pose T = Pose::Identity();
  T.linear() = svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
  T.translation() = model_mean - T.linear() * data_mean;
  return T;
}

/// What a span is measured along, per pose: seconds, metres of path or the pose's number.
std::vector<double> positions_along(const Trajectory& trajectory, DeltaUnit unit) {
  std::vector<double> positions(trajectory.size(), 0.0);
  for (size_t i = 1; i < trajectory.size(); ++i) {
    switch (unit) {
      case DeltaUnit::kSeconds:
        positions[i] = static_cast<double>(trajectory[i].timestamp_us - trajectory[0].timestamp_us) * 1e-6;
        break;
      case DeltaUnit::kMetres:
        positions[i] = positions[i - 1] + (trajectory[i].T_odom_camera.translation() -
                                           trajectory[i - 1].T_odom_camera.translation())
                                              .norm();
        break;
      case DeltaUnit::kFrames:
        positions[i] = static_cast<double>(i);
        break;
    }
  }
  return positions;
}

std::vector<StampPair> pair_stamps(const Trajectory& groundtruth, const Trajectory& estimate,
                                   int64_t max_difference_us, size_t needed) {
  std::vector<StampPair> pairs =
      associate_stamps(stamps_of(groundtruth), stamps_of(estimate), max_difference_us);
  if (pairs.size() < needed) {
    throw Error("only " + std::to_string(pairs.size()) +
                " poses of the estimate have a ground truth within " +
                std::to_string(max_difference_us / 1000) + " ms; do the two trajectories share a clock?");
  }
  return pairs;
}

}  // namespace

AbsoluteTrajectoryError absolute_trajectory_error(const Trajectory& groundtruth, const Trajectory& estimate,
                                                  int64_t max_difference_us) {
  const std::vector<int64_t> groundtruth_us = stamps_of(groundtruth), estimate_us = stamps_of(estimate);
  const std::vector<StampPair> pairs = pair_stamps(groundtruth, estimate, max_difference_us, 3);
  std::vector<Eigen::Vector3d> model, data;
  for (const StampPair& pair : pairs) {
    model.push_back(groundtruth[pair.first].T_odom_camera.translation());
    data.push_back(estimate[pair.second].T_odom_camera.translation());
  }

  AbsoluteTrajectoryError result;
  result.T_groundtruth_estimate = align(model, data);
  std::vector<double> errors_m;
  for (size_t i = 0; i < pairs.size(); ++i) {
    const Eigen::Vector3d p_estimate = result.T_groundtruth_estimate * data[i];
    errors_m.push_back((p_estimate - model[i]).norm());
    result.samples.push_back({estimate_us[pairs[i].second], model[i], p_estimate, errors_m.back()});
  }
  result.translation_m = summarise(errors_m);
  result.estimate_paired_share = static_cast<double>(pairs.size()) / static_cast<double>(estimate.size());

  std::vector<int64_t> sorted_us = estimate_us;
  std::sort(sorted_us.begin(), sorted_us.end());
  const auto covered = std::count_if(groundtruth_us.begin(), groundtruth_us.end(), [&](int64_t stamp_us) {
    return std::abs(sorted_us[closest(sorted_us, stamp_us)] - stamp_us) < max_difference_us;
  });
  result.groundtruth_covered_share = static_cast<double>(covered) / static_cast<double>(groundtruth.size());
  return result;
}

Pose align_poses(const Trajectory& groundtruth, const Trajectory& estimate, int64_t max_difference_us) {
  constexpr double kReach_m = 2;
  std::vector<Eigen::Vector3d> model, data;
  for (const StampPair& pair : pair_stamps(groundtruth, estimate, max_difference_us, 1)) {
    for (int axis = 0; axis < 3; ++axis) {
      for (const double reach_m : {-kReach_m, kReach_m}) {
        const Eigen::Vector3d p_camera = reach_m * Eigen::Vector3d::Unit(axis);
        model.push_back(groundtruth[pair.first].T_odom_camera * p_camera);
        data.push_back(estimate[pair.second].T_odom_camera * p_camera);
      }
    }
  }
  return align(model, data);
}

std::vector<RelativeError> relative_errors(const Trajectory& unsorted_groundtruth,
                                           const Trajectory& unsorted_estimate, double delta,
                                           DeltaUnit unit) {
  const std::vector<size_t> order = order_of(unsorted_estimate);
  const Trajectory estimate = sorted(unsorted_estimate, order);
  const Trajectory groundtruth = sorted(unsorted_groundtruth, order_of(unsorted_groundtruth));
  const std::vector<int64_t> groundtruth_us = stamps_of(groundtruth);
  const std::vector<double> positions = positions_along(estimate, unit);
  const double gap_us = max_gap_us(groundtruth_us);

  std::vector<RelativeError> errors;
  for (size_t i = 0; i < estimate.size() && !groundtruth.empty(); ++i) {
    const size_t j = closest(positions, positions[i] + delta);
    if (j + 1 == estimate.size()) continue;  // the span may reach beyond the end
    const size_t truth_i = closest(groundtruth_us, estimate[i].timestamp_us);
    const size_t truth_j = closest(groundtruth_us, estimate[j].timestamp_us);
    const auto is_missing = [&](size_t truth, size_t pose) {
      return static_cast<double>(std::abs(groundtruth_us[truth] - estimate[pose].timestamp_us)) > gap_us;
    };
    if (is_missing(truth_i, i) || is_missing(truth_j, j)) continue;
    const Pose T_j_i_estimate = estimate[j].T_odom_camera.inverse() * estimate[i].T_odom_camera;
    const Pose T_j_i_truth =
        groundtruth[truth_j].T_odom_camera.inverse() * groundtruth[truth_i].T_odom_camera;
    errors.push_back({order[i], order[j], T_j_i_estimate.inverse() * T_j_i_truth});
  }
  return errors;
}

std::optional<RelativePoseError> relative_pose_error(const Trajectory& groundtruth,
                                                     const Trajectory& estimate, double delta,
                                                     DeltaUnit unit) {
  std::vector<double> translations_m, rotations_deg;
  Eigen::Vector3d translation = Eigen::Vector3d::Zero(), rotation = Eigen::Vector3d::Zero();  // sums
  for (const RelativeError& error : relative_errors(groundtruth, estimate, delta, unit)) {
    translations_m.push_back(error.E.translation().norm());
    rotations_deg.push_back(rotation_angle(error.E) * 180 / std::numbers::pi);
    translation += error.E.translation();
    rotation += log_so3(error.E.linear());
  }
  if (translations_m.size() < 2) return std::nullopt;
  const auto pairs = static_cast<double>(translations_m.size());
  return RelativePoseError{summarise(translations_m), summarise(rotations_deg), translation / pairs,
                           rotation / pairs, static_cast<int64_t>(translations_m.size())};
}

}  // namespace kt
