// Thermal zones: the hottest counts, and those that say nothing sensible do not.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/core/temperature.h"

#include <fstream>
#include <gtest/gtest.h>

#include "tests/support/test_files.h"

namespace kt {
namespace {

TEST(Temperature, IsThatOfTheHottestZone) {
  const ScratchDir folder;
  EXPECT_FALSE(hottest_temperature_c(folder / "none"));
  const auto zone = [&](const char* name, const std::string& text) {
    std::filesystem::create_directory(folder / name);
    std::ofstream(folder / name / "temp") << text;
  };
  zone("cooling_device0", "99000\n");
  EXPECT_FALSE(hottest_temperature_c(folder.path()));
  zone("thermal_zone0", "45500\n");
  zone("thermal_zone1", "61200\n");
  zone("thermal_zone2", "-274000\n");  // a sensor that is off
  zone("thermal_zone3", "nonsense\n");
  EXPECT_EQ(hottest_temperature_c(folder.path()), 61);
}

}  // namespace
}  // namespace kt
