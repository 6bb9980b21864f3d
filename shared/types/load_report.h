// How busy the collector is: what its stages took, what waited, what was left out.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "shared/types/effort.h"

namespace kt {

/// What is timed, in the order of LoadReport::stages. "latency" lasts from a frame's arrival in the collector
/// to the end of the work on it, its time in the queue included; "frame" is that work.
inline constexpr std::array<std::string_view, 9> kLoadStages = {
    "latency", "frame", "preprocess", "track", "places", "shift", "integrate", "raycast", "remember"};

struct StageLoad {
  float median_ms = 0, p95_ms = 0, max_ms = 0;
};

/// Depends on the clock and the machine, unlike MissionStatus. Of a mission that is played again from
/// recorded frames all but the effort is zero.
struct LoadReport {
  int64_t sequence = 0;           ///< counts load reports
  int64_t timestamp_us = 0;       ///< of the last frame
  int64_t frames = 0;             ///< processed before the report
  Effort effort = Effort::kFull;  ///< of the frames behind it, up to the next report
  int64_t frames_dropped = 0;     ///< so far: they came while too many waited
  int frames_waiting = 0;
  std::array<StageLoad, kLoadStages.size()> stages{};  ///< since the report before it; 0 where none was run
};

}  // namespace kt
