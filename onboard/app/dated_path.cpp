// Puts dates into names.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/app/dated_path.h"

#include "shared/core/check.h"

namespace kt {

std::string dated_path(const std::string& pattern, std::time_t when) {
  std::tm utc{};
  gmtime_r(&when, &utc);
  std::string text;
  for (size_t i = 0; i < pattern.size(); ++i) {
    if (pattern[i] != '%') {
      text += pattern[i];
      continue;
    }
    const char letter = ++i < pattern.size() ? pattern[i] : '\0';
    if (letter == '\0' || std::string("YmdHMS%").find(letter) == std::string::npos)
      throw Error("'" + pattern + "': % must be followed by one of Y m d H M S, or by another %");
    char part[16];
    const char format[] = {'%', letter, '\0'};
    text.append(part, std::strftime(part, sizeof(part), format, &utc));
  }
  return text;
}

std::filesystem::path unused_dated_path(const std::string& pattern, std::time_t when) {
  const std::filesystem::path first = dated_path(pattern, when);
  constexpr std::time_t kOneTime = 0, kAnother = 1'000'000'000;  // that differ in every part
  if (dated_path(pattern, kOneTime) == dated_path(pattern, kAnother)) return first;
  std::error_code ignored;
  std::filesystem::path path = first;
  for (int i = 2; std::filesystem::exists(path, ignored); ++i) {
    path = first;
    path.replace_filename(first.stem().string() + "-" + std::to_string(i) + first.extension().string());
  }
  return path;
}

}  // namespace kt
