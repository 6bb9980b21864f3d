// Ground-truth trajectories in any of the forms that data sets keep them.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "shared/types/stamped_pose.h"

namespace kt {

/// The poses of a TUM trajectory file, of an ICL-NUIM *.gt.freiburg file (brought to the convention of
/// open_icl_nuim) or of a whole data set given as "7scenes:DIR", "icl:DIR" or "tum:DIR". Throws kt::Error
/// where there are none.
Trajectory read_groundtruth(const std::string& source);

/// Ground truth farther from a stamp than this, twice its usual interval, is missing, not close.
double max_gap_us(const std::vector<int64_t>& ascending_stamps_us);

/// The true pose at each stamp, between the ground-truth poses before and behind it; nothing where one of the
/// two is missing. Just outside of its span the first or last pose counts.
std::vector<std::optional<Pose>> poses_at(const Trajectory& groundtruth,
                                          const std::vector<int64_t>& stamps_us);

}  // namespace kt
