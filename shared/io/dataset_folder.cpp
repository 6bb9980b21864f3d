// Lists numbered files and finds a folder's calibration.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/io/dataset_folder.h"

#include "shared/core/check.h"
#include "shared/io/calibration_file.h"
#include "shared/io/text_lines.h"

namespace kt {

std::map<int64_t, std::filesystem::path> numbered_files(const std::filesystem::path& folder,
                                                        std::string_view prefix, std::string_view suffix) {
  std::error_code error;
  std::filesystem::directory_iterator files(folder, error);
  if (error) throw Error(folder.string() + ": cannot be listed: " + error.message());
  std::map<int64_t, std::filesystem::path> found;
  for (const auto& file : files) {
    const std::string name = file.path().filename().string();
    std::string_view number = name;
    if (!number.starts_with(prefix) || !number.ends_with(suffix)) continue;
    if (number.size() <= prefix.size() + suffix.size()) continue;
    number.remove_prefix(prefix.size());
    number.remove_suffix(suffix.size());
    if (number.size() > 9 || number.find_first_not_of("0123456789") != std::string_view::npos) continue;
    found[*parse_integer(number)] = file.path();
  }
  return found;
}

std::map<int64_t, std::filesystem::path> numbered_files(const std::filesystem::path& folder,
                                                        std::string_view prefix,
                                                        std::initializer_list<std::string_view> suffixes) {
  for (const std::string_view suffix : suffixes) {
    if (auto found = numbered_files(folder, prefix, suffix); !found.empty()) return found;
  }
  return {};
}

std::vector<Dataset::Entry> numbered_entries(const std::map<int64_t, std::filesystem::path>& depth,
                                             const std::map<int64_t, std::filesystem::path>& colour) {
  std::map<int64_t, Dataset::Entry> by_number;
  for (const auto& [number, path] : depth) by_number[number].depth = path;
  for (const auto& [number, path] : colour) by_number[number].colour = path;
  std::vector<Dataset::Entry> entries;
  for (auto& [number, entry] : by_number) {
    entry.timestamp_us = entry.colour_timestamp_us = stamp_at_30_hz_us(number);
    if (!depth.empty()) entries.push_back(std::move(entry));
  }
  return entries;
}

Calibration folder_calibration(const std::filesystem::path& folder, std::string_view name) {
  const std::filesystem::path own = folder / "calibration.yaml";
  return std::filesystem::exists(own) ? read_calibration(own) : builtin_calibration(name);
}

}  // namespace kt
