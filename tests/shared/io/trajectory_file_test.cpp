// TUM trajectories in and out.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/io/trajectory_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "shared/core/rng.h"
#include "tests/support/test_files.h"

namespace kt {
namespace {

using ::testing::HasSubstr;

Trajectory random_trajectory(uint64_t count) {
  Trajectory trajectory;
  for (uint64_t i = 0; i < count; ++i) {
    Vector6d xi;
    for (int k = 0; k < 6; ++k) xi[k] = 4 * random_uniform(7, static_cast<uint64_t>(k), i) - 2;
    trajectory.push_back({.sequence = static_cast<int64_t>(i),
                          .timestamp_us = 1305031102160407 + static_cast<int64_t>(i) * 33333,
                          .T_odom_camera = exp_se3(xi)});
  }
  return trajectory;
}

TEST(TrajectoryFile, SurvivesARoundTrip) {
  const ScratchDir folder;
  const Trajectory written = random_trajectory(200);
  write_trajectory(folder.path() / "t.txt", written);
  const Trajectory read = read_trajectory(folder.path() / "t.txt");
  ASSERT_EQ(read.size(), written.size());
  for (size_t i = 0; i < read.size(); ++i) {
    EXPECT_EQ(read[i].sequence, written[i].sequence);
    EXPECT_EQ(read[i].timestamp_us, written[i].timestamp_us);
    EXPECT_LT((read[i].T_odom_camera.matrix() - written[i].T_odom_camera.matrix()).cwiseAbs().maxCoeff(),
              5e-9);
  }
}

TEST(TrajectoryFile, ReadsTheFieldOrderOfTheBenchmark) {
  // A quarter turn about z.
  const Trajectory read = trajectory_from_text("# c\n1.5 1 2 3 0 0 0.70710678 0.70710678\n", "t");
  ASSERT_EQ(read.size(), 1u);
  const Eigen::Vector3d p = read[0].T_odom_camera * Eigen::Vector3d(1, 0, 0);
  EXPECT_LT((p - Eigen::Vector3d(1, 3, 3)).norm(), 1e-7);
}

TEST(TrajectoryFile, NamesTheBadLine) {
  const auto error = [](const char* line) {
    return error_of([&] { trajectory_from_text(std::string("1 0 0 0 0 0 0 1\n") + line, "poses.txt"); });
  };
  EXPECT_THAT(error("2 0 0 0 0 0 0"), HasSubstr("poses.txt, line 2: has 7 fields"));
  EXPECT_THAT(error("2 0 0 nan 0 0 0 1"), HasSubstr("line 2: 'nan'"));
  EXPECT_THAT(error("x 0 0 0 0 0 0 1"), HasSubstr("line 2: 'x' is not a time"));
  EXPECT_THAT(error("2 0 0 0 0 0 0 0"), HasSubstr("unit length"));
  EXPECT_THAT(error_of([] { read_trajectory("/no/such/file"); }), HasSubstr("/no/such/file: cannot be read"));
}

TEST(TrajectoryFile, ReadsTheBenchmarksOwnFiles) {
  KT_NEEDS_RECORDING("trajectories");
  EXPECT_EQ(read_trajectory(recordings() / "trajectories/freiburg1_desk-rgbdslam.txt").size(), 575u);
  EXPECT_EQ(read_trajectory(recordings() / "trajectories/freiburg1_desk-groundtruth.txt").size(), 2335u);
}

}  // namespace
}  // namespace kt
