// Trajectories in the TUM benchmark's text format: "timestamp tx ty tz qx qy qz qw" per line.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "shared/types/stamped_pose.h"

namespace kt {

/// The poses of `text`, in its order and numbered from 0; seconds become microseconds, quaternions unit
/// length. Throws kt::Error naming `name` and the line that is not a pose.
Trajectory trajectory_from_text(std::string_view text, const std::string& name);
Trajectory read_trajectory(const std::filesystem::path& path);

/// Stamps exact to the microsecond, other values to nine decimals.
std::string trajectory_to_text(const Trajectory& trajectory);
void write_trajectory(const std::filesystem::path& path, const Trajectory& trajectory);

}  // namespace kt
