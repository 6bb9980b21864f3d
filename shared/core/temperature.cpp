// Reads thermal zones: thermal_zoneN/temp holds thousandths of a degree.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/core/temperature.h"

#include <algorithm>
#include <fstream>
#include <system_error>

namespace kt {

std::optional<int> hottest_temperature_c(const std::filesystem::path& zones) {
  constexpr int kLowest = -100, kHighest = 300;
  std::optional<int> hottest;
  std::error_code error;
  std::filesystem::directory_iterator entry(zones, error), end;
  for (; !error && entry != end; entry.increment(error)) {
    if (!entry->path().filename().string().starts_with("thermal_zone")) continue;
    int millidegrees = 0;
    std::ifstream file(entry->path() / "temp");
    if (!(file >> millidegrees)) continue;  // a zone that is switched off answers with an error
    const int degrees = millidegrees / 1000;
    if (degrees < kLowest || degrees > kHighest || millidegrees == 0) continue;
    hottest = std::max(hottest.value_or(degrees), degrees);
  }
  return hottest;
}

}  // namespace kt
