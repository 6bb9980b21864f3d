// 7-Scenes folders: frame-N.depth.png, frame-N.color.jpg or .png, frame-N.pose.txt.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/io/dataset.h"
#include "shared/io/dataset_folder.h"
#include "shared/io/file.h"
#include "shared/io/text_lines.h"

namespace kt {
namespace {

/// A 4x4 matrix, row by row.
Pose read_pose_matrix(const std::filesystem::path& path) {
  const std::string text = read_file(path);
  TextLines lines(path.string(), text);
  Eigen::Matrix4d matrix;
  for (int row = 0; row < 4; ++row) {
    if (!lines.next()) lines.fail("a 4x4 matrix is needed");
    lines.expect_fields(4, "a row of a 4x4 matrix");
    for (int column = 0; column < 4; ++column)
      matrix(row, column) = lines.number(static_cast<size_t>(column));
  }
  const Pose T(matrix);
  if (!is_valid_pose(T, 1e-2)) lines.fail("the matrix is not a rigid transform");
  return orthonormalised(T);
}

Trajectory read_poses(const std::filesystem::path& folder) {
  Trajectory trajectory;
  for (const auto& [number, path] : numbered_files(folder, "frame-", ".pose.txt")) {
    trajectory.push_back({.sequence = static_cast<int64_t>(trajectory.size()),
                          .timestamp_us = stamp_at_30_hz_us(number),
                          .T_odom_camera = read_pose_matrix(path)});
  }
  return trajectory;
}

}  // namespace

Dataset open_seven_scenes(const std::filesystem::path& folder) {
  std::vector<Dataset::Entry> entries =
      numbered_entries(numbered_files(folder, "frame-", ".depth.png"),
                       numbered_files(folder, "frame-", {".color.png", ".color.jpg"}));
  return Dataset(
      std::move(entries), [folder] { return read_poses(folder); }, folder_calibration(folder, "7scenes"));
}

}  // namespace kt
