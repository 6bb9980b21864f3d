// A damaged log without its damage.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>

#include "shared/types/session.h"

namespace kt {

struct RepairOptions {
  std::filesystem::path
      output{};  ///< empty: NAME.repaired.lcm beside the log, or the log itself where in_place
  bool in_place = false;
  bool overwrite = false;  ///< replace what stands at the output
};

struct RepairReport {
  std::filesystem::path output{};  ///< the first file
  int64_t files = 0;
  LogIntegrity
      found{};  ///< of all files: events kept, events dropped as damaged, bytes skipped between events
  int64_t cut_bytes = 0;  ///< of an event that the log ends in
};

/// Writes every intact event of a log anew, in order, and leaves out the rest: events whose checksum fails,
/// bytes that are no event, a tail that is cut off. Part by part where the log was rolled; an undamaged file
/// stays as it is, byte by byte. A file is complete on the disk under another name before it takes its own.
/// The log itself is not touched but by in_place. Throws kt::Error where it cannot be read, is still being
/// written, holds no event, or the output exists or cannot be written.
RepairReport repair_log(const std::filesystem::path& log, const RepairOptions& options);

/// One or two lines for people.
std::string repair_text(const RepairReport& report);

}  // namespace kt
