// Tells the forms of ground truth apart by name, and interpolates it.
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/eval/groundtruth.h"

#include <algorithm>
#include <cstdlib>
#include <utility>

#include "shared/core/check.h"
#include "shared/io/dataset.h"
#include "shared/io/trajectory_file.h"
#include "tools/eval/statistics.h"

namespace kt {

Trajectory read_groundtruth(const std::string& source) {
  Trajectory poses;
  bool is_dataset = false;
  for (const std::string& format : dataset_formats()) {
    if (!source.starts_with(format + ":")) continue;
    poses = open_dataset(format, source.substr(format.size() + 1)).groundtruth();
    is_dataset = true;
  }
  if (!is_dataset)
    poses = source.ends_with(".gt.freiburg") ? read_icl_groundtruth(source) : read_trajectory(source);
  if (poses.empty()) throw Error(source + ": holds no poses");
  return poses;
}

double max_gap_us(const std::vector<int64_t>& ascending_stamps_us) {
  std::vector<double> intervals_us;
  for (size_t i = 1; i < ascending_stamps_us.size(); ++i) {
    intervals_us.push_back(static_cast<double>(ascending_stamps_us[i] - ascending_stamps_us[i - 1]));
  }
  return intervals_us.empty() ? 0 : 2 * quantile(std::move(intervals_us), 0.5);
}

std::vector<std::optional<Pose>> poses_at(const Trajectory& unsorted_groundtruth,
                                          const std::vector<int64_t>& stamps_us) {
  Trajectory groundtruth = unsorted_groundtruth;
  std::stable_sort(groundtruth.begin(), groundtruth.end(), [](const StampedPose& a, const StampedPose& b) {
    return a.timestamp_us < b.timestamp_us;
  });
  std::vector<int64_t> truth_us;
  for (const StampedPose& pose : groundtruth) truth_us.push_back(pose.timestamp_us);
  const double gap_us = max_gap_us(truth_us);

  std::vector<std::optional<Pose>> poses(stamps_us.size());
  for (size_t i = 0; i < stamps_us.size() && !groundtruth.empty(); ++i) {
    const int64_t stamp_us = stamps_us[i];
    auto b =
        static_cast<size_t>(std::lower_bound(truth_us.begin(), truth_us.end(), stamp_us) - truth_us.begin());
    b = std::min(b, truth_us.size() - 1);
    const size_t a = b > 0 && truth_us[b] > stamp_us ? b - 1 : b;
    const auto is_far = [&](size_t k) {
      return static_cast<double>(std::abs(truth_us[k] - stamp_us)) > gap_us;
    };
    if (is_far(a) || is_far(b)) continue;
    const auto span_us = static_cast<double>(truth_us[b] - truth_us[a]);
    const double share = a == b ? 0 : static_cast<double>(stamp_us - truth_us[a]) / span_us;
    const Pose& T_a = groundtruth[a].T_odom_camera;
    poses[i] = T_a * exp_se3(share * log_se3(T_a.inverse() * groundtruth[b].T_odom_camera));
  }
  return poses;
}

}  // namespace kt
