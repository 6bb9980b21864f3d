// Parses and prints TUM trajectories.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/io/trajectory_file.h"

#include <cmath>

#include "shared/core/check.h"
#include "shared/io/file.h"
#include "shared/io/number_text.h"
#include "shared/io/text_lines.h"

namespace kt {

Trajectory trajectory_from_text(std::string_view text, const std::string& name) {
  Trajectory trajectory;
  TextLines lines(name, text);
  while (lines.next()) {
    lines.expect_fields(8, "timestamp tx ty tz qx qy qz qw");
    StampedPose pose;
    pose.sequence = static_cast<int64_t>(trajectory.size());
    pose.timestamp_us = lines.stamp_us(0);
    pose.T_odom_camera.translation() = Eigen::Vector3d(lines.number(1), lines.number(2), lines.number(3));
    const Eigen::Quaterniond q(lines.number(7), lines.number(4), lines.number(5), lines.number(6));
    // Files in the wild carry three or four decimals.
    if (!(std::abs(q.norm() - 1) < 0.05)) lines.fail("the quaternion does not have unit length");
    pose.T_odom_camera.linear() = q.normalized().toRotationMatrix();
    trajectory.push_back(pose);
  }
  return trajectory;
}

Trajectory read_trajectory(const std::filesystem::path& path) {
  const std::string text = read_file(path);
  return trajectory_from_text(text, path.string());
}

std::string trajectory_to_text(const Trajectory& trajectory) {
  std::string text = "# timestamp tx ty tz qx qy qz qw\n";
  for (const StampedPose& pose : trajectory) {
    Eigen::Quaterniond q(pose.T_odom_camera.linear());
    q.normalize();
    if (q.w() < 0) q.coeffs() = -q.coeffs();
    text += format_stamp_us(pose.timestamp_us);
    for (const double value : pose.T_odom_camera.translation()) text += ' ' + fixed_text(value, 9);
    for (const double value : q.coeffs()) text += ' ' + fixed_text(value, 9);
    text += "\n";
  }
  return text;
}

void write_trajectory(const std::filesystem::path& path, const Trajectory& trajectory) {
  write_file(path, trajectory_to_text(trajectory));
}

}  // namespace kt
