// Calibrations as small YAML files, and the cameras known by name.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "shared/types/calibration.h"

namespace kt {

/// Reads a calibration from YAML; README.md of this folder shows one. `colour` defaults to the depth camera,
/// T_colour_depth to identity. Throws kt::Error naming `name` and the key that is missing, unknown or absurd.
Calibration calibration_from_yaml(const std::string& yaml, const std::string& name);
Calibration read_calibration(const std::filesystem::path& path);

/// Reads back as the same doubles; T_colour_depth as a unit quaternion, hence to rounding error.
std::string calibration_to_yaml(const Calibration& calibration);
void write_calibration(const std::filesystem::path& path, const Calibration& calibration);

/// The camera of a public data set; throws kt::Error listing the known names.
Calibration builtin_calibration(std::string_view name);
std::vector<std::string> builtin_calibration_names();

/// A calibration by name or, where `name_or_path` is no known name, from that file.
Calibration find_calibration(const std::string& name_or_path);

}  // namespace kt
