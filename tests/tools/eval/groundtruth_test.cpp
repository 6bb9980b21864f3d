// True poses between the stamps of the ground truth.
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/eval/groundtruth.h"

#include <gtest/gtest.h>

namespace kt {
namespace {

// Turning and moving evenly: after t milliseconds at exp(t xi).
Pose pose_after(double t) { return exp_se3(t * (Vector6d() << 0.02, 0.01, -0.01, 0.1, 0, 0.05).finished()); }

Trajectory even_motion(const std::vector<int>& milliseconds) {
  Trajectory truth;
  for (const int t : milliseconds)
    truth.push_back({.timestamp_us = 1000 * t, .T_odom_camera = pose_after(t)});
  return truth;
}

TEST(PosesAt, AreExactAtStampsAndEvenBetweenThem) {
  const Trajectory truth = even_motion({30, 0, 20, 10, 40});  // in any order
  const auto poses = poses_at(truth, {20'000, 12'500, 39'999, 0});
  ASSERT_EQ(poses.size(), 4u);
  EXPECT_EQ(poses[0]->matrix(), pose_after(20).matrix());
  EXPECT_TRUE(poses[1]->isApprox(pose_after(12.5), 1e-12));
  EXPECT_TRUE(poses[2]->isApprox(pose_after(39.999), 1e-12));
  EXPECT_EQ(poses[3]->matrix(), pose_after(0).matrix());
}

TEST(PosesAt, AreMissingInGapsAndFarOutside) {
  const Trajectory truth = even_motion({0, 10, 20, 30, 100, 110});
  const auto poses = poses_at(truth, {-20'000, -20'001, 30'000, 31'000, 65'000, 129'000, 130'001});
  EXPECT_EQ(poses[0]->matrix(), pose_after(0).matrix());
  EXPECT_FALSE(poses[1]);
  EXPECT_TRUE(poses[2]);
  EXPECT_FALSE(poses[3]) << "the next is 69 ms away";
  EXPECT_FALSE(poses[4]);
  EXPECT_EQ(poses[5]->matrix(), pose_after(110).matrix());
  EXPECT_FALSE(poses[6]);
  EXPECT_EQ(poses_at(even_motion({5}), {5000})[0]->matrix(), pose_after(5).matrix());
  EXPECT_FALSE(poses_at(even_motion({5}), {5001})[0]);
  EXPECT_FALSE(poses_at({}, {5000})[0]);
}

}  // namespace
}  // namespace kt
