// Tests of colours brought to another exposure, against a slow formula.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/preprocess/correct_colour_kernel.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "gtest/gtest.h"

#include "shared/core/check.h"
#include "tests/onboard/preprocess/host_maps.h"

namespace kt::test {
namespace {

uint32_t packed(int r, int g, int b, int a) {
  return Rgb8{static_cast<uint8_t>(r), static_cast<uint8_t>(g), static_cast<uint8_t>(b)}.packed() |
         static_cast<uint32_t>(a) << 24;
}

uint32_t corrected(uint32_t rgba, Vec3f factor) {
  CorrectColour{factor, &rgba}(0);
  return rgba;
}

TEST(CorrectColour, MultipliesRoundsAndClamps) {
  for (const double factor : {0.4, 0.93, 1.0, 1.08, 2.5}) {
    for (int level = 0; level < 256; ++level) {
      const int expected = static_cast<int>(
          std::min(255.0, std::floor(static_cast<double>(static_cast<float>(factor)) * level + 0.5)));
      const auto f = static_cast<float>(factor);
      const int trust = level >= kClippedLevel ? static_cast<int>(kClippedTrust) : 255;
      EXPECT_EQ(corrected(packed(level, 7, 0, 255), {f, 1, 1}), packed(expected, 7, 0, trust));
      EXPECT_EQ(corrected(packed(9, level, 8, 255), {1, f, 1}), packed(9, expected, 8, trust));
      EXPECT_EQ(corrected(packed(9, 8, level, 255), {1, 1, f}), packed(9, 8, expected, trust));
    }
  }
  EXPECT_EQ(corrected(0, {2, 2, 2}), 0u) << "no colour stays none";
}

TEST(CorrectColour, ReachesEveryPixelOfTheFrame) {
  const Calibration calibration = small_calibration();
  Preprocessor preprocessor(exec::Device::cpu(2), calibration, {});
  RgbdFrame frame = render(furnished_room(), calibration, Pose::Identity());
  const HostMaps before(preprocessor.process(frame));
  preprocessor.correct_colour({0.5f, 1.0f, 1.5f});
  const HostMaps after(preprocessor.process(frame));
  EXPECT_EQ(after.colours, before.colours) << "the next frame is its own";
  preprocessor.correct_colour({0.5f, 1.0f, 1.5f});
  frame.colour = {};
  const FrameMaps& without = preprocessor.process(frame);
  const std::vector<uint32_t> colours = without.registered_colour.downloaded();
  preprocessor.correct_colour({0.5f, 1.0f, 1.5f});
  EXPECT_EQ(without.registered_colour.downloaded(), colours) << "those of an earlier frame";
  ASSERT_EQ(colours.size(), before.colours.size());
  for (size_t i = 0; i < colours.size(); ++i)
    EXPECT_EQ(colours[i], corrected(before.colours[i], {0.5f, 1.0f, 1.5f}));
  EXPECT_THROW(preprocessor.correct_colour({0, 1, 1}), LogicError);
}

}  // namespace
}  // namespace kt::test
