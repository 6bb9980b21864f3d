// How hot this computer is, as Linux tells it.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <optional>

namespace kt {

/// Degrees Celsius of the hottest thermal zone; nothing where there is none to read, or none that makes
/// sense.
std::optional<int> hottest_temperature_c(const std::filesystem::path& zones = "/sys/class/thermal");

}  // namespace kt
