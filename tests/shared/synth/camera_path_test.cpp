// The camera path: smooth to the second derivative, at rest at its ends, near its way points.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/synth/camera_path.h"

#include <gtest/gtest.h>

#include "shared/core/check.h"

namespace kt {
namespace {

using Eigen::Vector3d;

const std::vector<WayPoint> kWayPoints = {
    {{0, 0, 1}, {2, 0, 1}}, {{2, 0, 1.2}, {2, 2, 1}}, {{2, 2, 1}, {0, 2, 0.5}}, {{0, 2, 1}, {-2, 2, 1}}};
const PathPace kPace{0.5, 0.6, 0.4, 0.01, 9};

Vector3d velocity(const CameraPath& path, double t, double h) {
  return (path.at(t + h).translation() - path.at(t).translation()) / h;
}

TEST(CameraPath, StartsAndEndsAtRestLookingAtItsTargets) {
  const CameraPath path(kWayPoints, kPace);
  const double end = path.duration_s();
  const Pose first = path.at(0), last = path.at(end);
  EXPECT_LT((first.translation() - Vector3d(0, 0, 1)).norm(), 1e-12);
  EXPECT_LT((last.translation() - Vector3d(0, 2, 1)).norm(), 1e-12);
  EXPECT_LT((first.linear().col(2) - Vector3d(1, 0, 0)).norm(), 1e-12);
  EXPECT_LT((first.linear().col(1) - Vector3d(0, 0, -1)).norm(), 1e-12);  // y down
  EXPECT_LT(velocity(path, 0, 1e-3).norm(), 1e-4);
  EXPECT_LT(velocity(path, end - 1e-3, 1e-3).norm(), 1e-4);
  EXPECT_EQ(path.at(-1).matrix(), first.matrix());
  EXPECT_EQ(path.at(end + 1).matrix(), last.matrix());
}

TEST(CameraPath, AccelerationHasNoJumps) {
  const CameraPath path(kWayPoints, kPace);
  const double h = 1e-3;
  double largest = 0, largest_jump = 0, largest_turn_jump = 0;
  const auto second = [&](double t, auto value) {
    return Vector3d((value(t + h) - 2 * value(t) + value(t - h)) / (h * h));
  };
  const auto position = [&](double t) { return Vector3d(path.at(t).translation()); };
  const auto forward = [&](double t) { return Vector3d(path.at(t).linear().col(2)); };
  for (double t = 2 * h; t < path.duration_s() - 0.05; t += 0.005) {
    largest = std::max(largest, second(t, position).norm());
    largest_jump = std::max(largest_jump, (second(t + 0.005, position) - second(t, position)).norm());
    largest_turn_jump = std::max(largest_turn_jump, (second(t + 0.005, forward) - second(t, forward)).norm());
  }
  // Acceleration is piecewise linear: within 5 ms of a knot spacing of 400 ms it changes little. A jump would
  // show whole.
  EXPECT_GT(largest, 0.5);
  EXPECT_LT(largest_jump, 0.08 * largest);
  EXPECT_LT(largest_turn_jump, 0.2);
}

TEST(CameraPath, KeepsItsPaceAndPassesItsWayPoints) {
  PathPace steady = kPace;
  steady.sway_m = 0;
  const CameraPath path(kWayPoints, steady);
  std::vector<double> closest(kWayPoints.size(), 1e9);
  for (double t = 0; t < path.duration_s(); t += 0.01) {
    const Pose T = path.at(t);
    EXPECT_TRUE(is_valid_pose(T, 1e-9));
    EXPECT_LE(velocity(path, t, 0.01).norm(), steady.speed_mps * 1.001);
    EXPECT_LE(rotation_angle(T.inverse() * path.at(t + 0.01)) / 0.01, steady.turn_rate_rps * 1.3);
    for (size_t i = 0; i < closest.size(); ++i) {
      closest[i] = std::min(closest[i], (T.translation() - kWayPoints[i].p_world).norm());
    }
  }
  for (const double distance : closest) EXPECT_LT(distance, 0.1);
}

TEST(CameraPath, NeedsTwoWayPoints) { EXPECT_THROW(CameraPath({kWayPoints[0]}, kPace), LogicError); }

}  // namespace
}  // namespace kt
