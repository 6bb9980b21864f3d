// What the data set readers share: finding numbered files, 30 Hz stamps, the folder's own calibration.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "shared/io/dataset.h"
#include "shared/types/calibration.h"

namespace kt {

/// Files of `folder` named <prefix><digits><suffix>, by their number. Throws kt::Error where the folder is
/// missing.
std::map<int64_t, std::filesystem::path> numbered_files(const std::filesystem::path& folder,
                                                        std::string_view prefix, std::string_view suffix);
/// The same with the first suffix that any file has: colour may be stored as .png or .jpg.
std::map<int64_t, std::filesystem::path> numbered_files(const std::filesystem::path& folder,
                                                        std::string_view prefix,
                                                        std::initializer_list<std::string_view> suffixes);

/// Time of frame `index` at 30 Hz, for recordings that keep no stamps.
constexpr int64_t stamp_at_30_hz_us(int64_t index) { return (index * 1'000'000 + 15) / 30; }

/// One entry per number that either list has, stamped at 30 Hz, so that a missing depth image is a frame that
/// cannot be loaded; none where there is no depth at all.
std::vector<Dataset::Entry> numbered_entries(const std::map<int64_t, std::filesystem::path>& depth,
                                             const std::map<int64_t, std::filesystem::path>& colour);

/// calibration.yaml of `folder` where there is one, else the built-in calibration `name`.
Calibration folder_calibration(const std::filesystem::path& folder, std::string_view name);

}  // namespace kt
