// The end report of a mission: for people on the terminal, for programs as JSON.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>

#include "onboard/app/mission.h"

namespace kt {

/// A few lines: frames, tracking, slices, ms per stage, memory.
std::string mission_report_text(const MissionSummary& summary);

/// The same as JSON. Throws kt::Error where the file cannot be written.
void write_mission_report(const MissionSummary& summary, const std::filesystem::path& path);

}  // namespace kt
