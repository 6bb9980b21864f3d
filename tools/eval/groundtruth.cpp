// Tells the forms of ground truth apart by name.
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/eval/groundtruth.h"

#include "shared/core/check.h"
#include "shared/io/dataset.h"
#include "shared/io/trajectory_file.h"

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

}  // namespace kt
