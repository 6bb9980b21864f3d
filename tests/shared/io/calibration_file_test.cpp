// Calibration files: round trip, strictness, and the built-in cameras.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/io/calibration_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <regex>

#include "shared/io/file.h"
#include "tests/support/test_files.h"

namespace kt {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr const char* kMinimal =
    "depth: {width: 640, height: 480, fx: 500, fy: 501, cx: 320, cy: 240}\n"
    "depth_unit_m: 0.001\n";

TEST(CalibrationFile, SurvivesARoundTrip) {
  for (const std::string& name : builtin_calibration_names()) {
    Calibration written = builtin_calibration(name);
    written.T_colour_depth.linear() = exp_so3({0.01, -0.02, 0.03});
    const Calibration read = calibration_from_yaml(calibration_to_yaml(written), name);
    EXPECT_EQ(read.name, name);
    EXPECT_EQ(read.depth, written.depth);
    EXPECT_EQ(read.colour, written.colour);
    EXPECT_EQ(read.depth_unit_m, written.depth_unit_m);
    EXPECT_EQ(read.invalid_depth, written.invalid_depth);
    EXPECT_EQ(read.readout_s, written.readout_s);
    EXPECT_EQ(read.stamp_delay_s, written.stamp_delay_s);
    EXPECT_TRUE(read.T_colour_depth.isApprox(written.T_colour_depth, 1e-14));
  }
}

TEST(CalibrationFile, KeepsARegisteredCameraRegistered) {
  const Calibration written = builtin_calibration("tum-fr1");
  ASSERT_TRUE(written.is_registered());
  EXPECT_TRUE(calibration_from_yaml(calibration_to_yaml(written), "c").is_registered());
}

TEST(CalibrationFile, ColourDefaultsToTheDepthCamera) {
  const Calibration read = calibration_from_yaml(kMinimal, "c");
  EXPECT_EQ(read.colour, read.depth);
  EXPECT_EQ(read.depth.fy, 501);
  EXPECT_TRUE(read.is_registered());
}

TEST(CalibrationFile, OddNamesSurvive) {
  Calibration written = builtin_calibration("tum");
  for (const char* name : {"", "front: left #2", "yes", "'quoted\" \\ name"}) {
    written.name = name;
    EXPECT_EQ(calibration_from_yaml(calibration_to_yaml(written), "c").name, name);
  }
}

TEST(CalibrationFile, NamesFileAndKeyOfEveryFault) {
  const auto error = [](const std::string& from, const std::string& to) {
    const std::string yaml = std::regex_replace(std::string(kMinimal), std::regex(from), to);
    EXPECT_NE(yaml, kMinimal);
    return error_of([&] { calibration_from_yaml(yaml, "rig.yaml"); });
  };
  EXPECT_THAT(error("fx: 500", "fx: -500"), AllOf(HasSubstr("rig.yaml"), HasSubstr("fx is -500")));
  EXPECT_THAT(error("fx: 500", "fx: .nan"), HasSubstr("fx is nan"));
  EXPECT_THAT(error("fx: 500", "fx: wide"), HasSubstr("depth.fx must be a number"));
  EXPECT_THAT(error("fx: 500, ", ""), HasSubstr("depth.fx is missing"));
  EXPECT_THAT(error("fx: 500", "fx: 500, skew: 1"), HasSubstr("depth.skew is unknown"));
  EXPECT_THAT(error("width: 640", "width: 0"), HasSubstr("width is 0"));
  EXPECT_THAT(error("width: 640", "width: 6.5"), HasSubstr("depth.width must be a whole number"));
  EXPECT_THAT(error("0.001", "0"), HasSubstr("depth_unit_m"));
  EXPECT_THAT(error("depth_unit_m: 0.001", ""), HasSubstr("depth_unit_m is missing"));
  EXPECT_THAT(error("0.001", "0.001\ninvalid_depth: 70000"), HasSubstr("invalid_depth must lie in"));
  EXPECT_THAT(
      error("0.001", "0.001\nT_colour_depth: {translation_m: [0, 0, 0], quaternion_xyzw: [0, 0, 0, 2]}"),
      HasSubstr("T_colour_depth.quaternion_xyzw must have length 1"));
  EXPECT_THAT(error("0.001", "0.001\nT_colour_depth: {translation_m: [0, 0], quaternion_xyzw: [0, 0, 0, 1]}"),
              HasSubstr("T_colour_depth.translation_m must be three numbers"));
  EXPECT_THAT(
      error("0.001", "0.001\nT_colour_depth: {translation_m: [5, 0, 0], quaternion_xyzw: [0, 0, 0, 1]}"),
      HasSubstr("more than 1 m apart"));
  EXPECT_THAT(error("cy: 240", "cy: 240, distortion: [1, 2]"),
              HasSubstr("depth.distortion must be five numbers"));
  EXPECT_THAT(error("cy: 240", "cy: 240, distortion: [0, 0, a, 0, 0]"),
              HasSubstr("depth.distortion must be five numbers"));
  EXPECT_THAT(error("cy: 240", "cy: 240, distortion: [0, 0, [1], 0, 0]"),
              HasSubstr("depth.distortion must be five numbers"));
  EXPECT_THAT(error("cy: 240", "cy: 240, distortion: {a: 1}"),
              HasSubstr("depth.distortion must be five numbers"));
  EXPECT_THAT(error("fx: 500", "fx: [500]"), HasSubstr("depth.fx must be a number"));
  EXPECT_THAT(error("fx: 500", "fx: 500, fx: 400"), HasSubstr("depth.fx is given twice"));
  EXPECT_THAT(error("0.001", "0.001\ndepth_unit_m: 0.002"), HasSubstr("depth_unit_m is given twice"));
  EXPECT_THAT(error("0.001", "0.001\n[a, b]: 1"), HasSubstr("a key that is no word"));
  EXPECT_THAT(error("0.001", "0.001\nname: [a]"), HasSubstr("name must be text"));
  EXPECT_THAT(error("cy: 240}", "cy: 240"), HasSubstr("not valid YAML"));
  EXPECT_THAT(error_of([] { calibration_from_yaml("- 1\n", "rig.yaml"); }), HasSubstr("must be a mapping"));
  EXPECT_THAT(error_of([] { calibration_from_yaml("", "rig.yaml"); }), HasSubstr("must be a mapping"));
}

TEST(CalibrationFile, BuiltInCamerasMakeSense) {
  for (const std::string& name : builtin_calibration_names())
    EXPECT_EQ(builtin_calibration(name).problem(), "") << name;
  EXPECT_FALSE(builtin_calibration("7scenes").is_registered());
  EXPECT_THAT(error_of([] { builtin_calibration("kinect9"); }),
              AllOf(HasSubstr("kinect9"), HasSubstr("tum-fr1, tum-fr2")));
}

TEST(CalibrationFile, IsFoundByNameOrPath) {
  const ScratchDir folder;
  write_file(folder.path() / "rig.yaml", kMinimal);
  EXPECT_EQ(find_calibration((folder.path() / "rig.yaml").string()).depth.fx, 500);
  EXPECT_EQ(find_calibration("tum-fr3").depth.fx, 535.4);
  EXPECT_THAT(error_of([] { find_calibration("no-such-rig"); }), HasSubstr("no-such-rig"));
}

}  // namespace
}  // namespace kt
