// Ground-truth trajectories in any of the forms that data sets keep them.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "shared/types/stamped_pose.h"

namespace kt {

/// The poses of a TUM trajectory file, of an ICL-NUIM *.gt.freiburg file (brought to the convention of
/// open_icl_nuim) or of a whole data set given as "7scenes:DIR", "icl:DIR" or "tum:DIR". Throws kt::Error
/// where there are none.
Trajectory read_groundtruth(const std::string& source);

}  // namespace kt
