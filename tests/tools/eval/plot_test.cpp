// Plots are drawn where gnuplot is, and its absence is named.
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/eval/plot.h"

#include <cstdlib>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "shared/io/image_file.h"
#include "tests/support/test_files.h"

namespace kt {
namespace {

using ::testing::HasSubstr;

AbsoluteTrajectoryError some_trajectory_error() {
  Trajectory truth, estimate;
  for (int i = 0; i < 50; ++i) {
    StampedPose pose{.sequence = i, .timestamp_us = i * 33'333};
    pose.T_odom_camera.translation() = Eigen::Vector3d(std::cos(0.1 * i), std::sin(0.1 * i), 0);
    truth.push_back(pose);
    pose.T_odom_camera.translation().z() += 0.01 * (i % 3);
    estimate.push_back(pose);
  }
  return absolute_trajectory_error(truth, estimate);
}

/// Runs a test without gnuplot on the path, and puts the path back.
class WithoutPath {
 public:
  WithoutPath() : path_(std::getenv("PATH")) { setenv("PATH", "/nonexistent", 1); }
  ~WithoutPath() { setenv("PATH", path_.c_str(), 1); }

 private:
  std::string path_;
};

TEST(Plot, DrawsPictures) {
  if (std::system("command -v gnuplot >/dev/null") != 0) GTEST_SKIP() << "gnuplot is not installed";
  const ScratchDir folder;
  const auto png = folder.path() / "it's a plot.png";
  plot_trajectory_error(some_trajectory_error(), png);
  EXPECT_EQ(read_colour(png).width(), 1200);
  SurfaceError error;
  error.accuracy_distances_m = error.completeness_distances_m = {0.001, 0.002, 0.03};
  plot_surface_error(error, 0.02, png);
  EXPECT_EQ(read_colour(png).height(), 900);
  EXPECT_THAT(error_of([&] { plot_surface_error(error, 0.02, folder.path() / "none/p.png"); }),
              HasSubstr("could not draw"));
}

TEST(Plot, NamesTheMissingProgram) {
  const AbsoluteTrajectoryError error = some_trajectory_error();
  const WithoutPath without_path;
  EXPECT_THAT(error_of([&] { plot_trajectory_error(error, "/tmp/p.png"); }),
              HasSubstr("install the package gnuplot-nox"));
}

}  // namespace
}  // namespace kt
