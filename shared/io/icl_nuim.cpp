// ICL-NUIM folders, and what becomes of their negative focal length.
// SPDX-License-Identifier: BSD-3-Clause
//
// The benchmark states fy = -480 and poses T_world_camera: its camera looks along +z with y up, a left-handed
// frame, and so is its world. With M = diag(1, -1, 1), a pixel (u, v) at depth z is the point p = M p', where
// p' = ((u - cx) / 481.2 z, (v - cy) / 480 z, z) is what an ordinary camera (y down, fy = +480) makes of the
// untouched image. From p_world = R p + t follows M p_world = (M R M) p' + M t: an ordinary camera with T' =
// M T M in the world mirrored at y = 0. That world is the right-handed one a person would see, writing in it
// reads as it should, and images stay as they are. (To flip the images upside down and keep T would do as
// well, and leave a mirrored room with mirrored writing. To do neither, or both, is the trap.) A ground-truth
// mesh of the benchmark has to be mirrored likewise: mirrored_y in mesh.h.
//
// Poses are numbered by image, from 1: image 0 has none.
#include <algorithm>

#include "shared/core/check.h"
#include "shared/io/dataset.h"
#include "shared/io/dataset_folder.h"
#include "shared/io/trajectory_file.h"

namespace kt {
namespace {

std::filesystem::path find_groundtruth(const std::filesystem::path& folder) {
  std::filesystem::path found;
  for (const auto& file : std::filesystem::directory_iterator(folder)) {
    if (!file.path().filename().string().ends_with(".gt.freiburg")) continue;
    if (!found.empty())
      throw Error(folder.string() + ": holds more than one *.gt.freiburg file; keep the right one");
    found = file.path();
  }
  return found;
}

}  // namespace

Trajectory read_icl_groundtruth(const std::filesystem::path& path) {
  const Eigen::DiagonalMatrix<double, 3> M(1, -1, 1);
  Trajectory trajectory = read_trajectory(path);
  // The benchmark's own files number the images, which read_trajectory takes for seconds; copies may carry
  // real times.
  constexpr int64_t kSecond = 1'000'000;
  const bool numbered = std::all_of(trajectory.begin(), trajectory.end(),
                                    [](const StampedPose& pose) { return pose.timestamp_us % kSecond == 0; });
  for (StampedPose& pose : trajectory) {
    if (numbered) pose.timestamp_us = stamp_at_30_hz_us(pose.timestamp_us / kSecond);
    const Pose T = pose.T_odom_camera;
    pose.T_odom_camera.linear() = M * T.linear() * M;
    pose.T_odom_camera.translation() = M * T.translation();
  }
  return trajectory;
}

Dataset open_icl_nuim(const std::filesystem::path& folder) {
  std::vector<Dataset::Entry> entries = numbered_entries(
      numbered_files(folder / "depth", "", ".png"), numbered_files(folder / "rgb", "", {".png", ".jpg"}));
  const auto read_groundtruth = [folder] {
    const std::filesystem::path poses = find_groundtruth(folder);
    return poses.empty() ? Trajectory{} : read_icl_groundtruth(poses);
  };
  return Dataset(std::move(entries), read_groundtruth, folder_calibration(folder, "icl-nuim"));
}

}  // namespace kt
