// The end report of a mission: for people on the terminal, for programs as JSON.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>

#include "onboard/app/mission.h"

namespace kt {

/// A mission on its way, for a line that is redrawn: "frame 12 of 600  14.5 Hz  uncertain (few inliers, 43 %)
/// 2 slices  0 skipped"; in the brackets what gave the last pose where that was not the model, why it is not
/// good, and the share of inliers. `frame_count` below 0 means unknown; `seconds` is the wall time so far.
std::string mission_progress_text(const MissionStatus& status, int64_t frame_count, double seconds);

/// A few lines: frames, tracking and its worst stretches, slices, ms per stage, memory. The row "fallback" is
/// of those whole frames that were not placed by the model and the predicted motion alone.
/// "12 raw frames, 3 slices": what did not go into the log.
std::string not_stored_text(const StorageState& storage);

std::string mission_report_text(const MissionSummary& summary);

/// The same as JSON; its fields are listed in the README. Throws kt::Error where the file cannot be written.
void write_mission_report(const MissionSummary& summary, const std::filesystem::path& path);

}  // namespace kt
