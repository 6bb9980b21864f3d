// The files of a log that was rolled: NAME.lcm, NAME.001.lcm, NAME.002.lcm and so on.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <vector>

namespace kt {

/// What is there of a log. Every part begins with the mission's session event, whose sequence number is that
/// of the part; all other numbers go on from part to part, so that the files read one behind the other are
/// one log.
struct LogParts {
  std::vector<std::filesystem::path> paths;  ///< in order; at least the one that was asked for
  int64_t missing = 0;                       ///< gaps in their numbers
};

/// Where part `number` of the log `first` lies; part 0 is `first` itself.
std::filesystem::path log_part_path(const std::filesystem::path& first, int64_t number);

/// `path` and the parts behind it: of the first part all, of a later one those that follow. A file of such a
/// name that begins with the session of another mission is none of them. Never throws: a file that is missing
/// or damaged is for whoever reads it.
LogParts log_parts(const std::filesystem::path& path);

/// The logs that `paths` names where parts of them may be named too, as by mission*.lcm: without parts that
/// another of them finds.
std::vector<std::filesystem::path> without_later_parts(const std::vector<std::filesystem::path>& paths);

/// Files that stand where later parts of the log `first` would, by their number, whatever they hold.
std::map<int64_t, std::filesystem::path> numbered_files(const std::filesystem::path& first);
/// Whether a file begins with the session of part `number` of some log.
bool is_log_part(const std::filesystem::path& path, int64_t number);

}  // namespace kt
