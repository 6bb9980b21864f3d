// Odometry of the robot beside a recording: a TUM trajectory whose head says how its error grows.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "shared/types/motion_sample.h"

namespace kt {

/// What a file without the line on its sigmas is taken for: a plain robot on wheels, or a phone.
inline constexpr double kDefaultRotationSigma = 0.02;     ///< rad per square root of a second
inline constexpr double kDefaultTranslationSigma = 0.02;  ///< m per square root of a second

/// The pose samples of `text`, in its order and numbered from 0: poses of the depth camera in the odometry's
/// frame or, after a comment "# of body", of the robot's body, as trajectory_from_text reads them. A comment
/// before the first pose may say
/// "# rotation_sigma <v> translation_sigma <v>"; rotation_sigma is above 0, translation_sigma 0 where it is
/// not measured. Throws kt::Error naming `name` and the line that is wrong.
std::vector<MotionSample> odometry_from_text(std::string_view text, const std::string& name);
std::vector<MotionSample> read_odometry(const std::filesystem::path& path);

/// The inverse. A file has one pair of sigmas: the largest of each among `samples`, which are poses.
std::string odometry_to_text(const std::vector<MotionSample>& samples);
void write_odometry(const std::filesystem::path& path, const std::vector<MotionSample>& samples);

}  // namespace kt
