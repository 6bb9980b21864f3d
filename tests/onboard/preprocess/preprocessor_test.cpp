// Tests of the preprocessor as a whole: sizes, errors, and equal bits on every device.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/preprocess/preprocessor.h"

#include "gmock/gmock.h"
#include "gtest/gtest.h"

#include "shared/core/digest.h"
#include "tests/onboard/preprocess/host_maps.h"
#include "tests/support/devices.h"

namespace kt::test {
namespace {

uint64_t digest_of(const FrameMaps& maps) {
  Digest digest;
  for (const SurfaceLevel& level : maps.levels) {
    digest.add(std::span<const float>(level.depth.downloaded()));
    digest.add(std::span<const Vec4f>(level.normals.downloaded()));
  }
  digest.add(std::span<const FusionPixel>(maps.fusion_pixels.downloaded()));
  digest.add(std::span<const uint32_t>(maps.registered_colour.downloaded()));
  return digest.value();
}

TEST(Preprocessor, BuildsAPyramidOfHalves) {
  const Calibration calibration = small_calibration();
  Preprocessor preprocessor(exec::Device::cpu(1), calibration, {});
  const FrameMaps& maps = preprocessor.process(render(furnished_room(), calibration, Pose::Identity()));
  int width = 160, height = 120;
  for (const SurfaceLevel& level : maps.levels) {
    EXPECT_EQ(level.camera.width, width);
    EXPECT_EQ(level.camera.height, height);
    EXPECT_EQ(level.normals.size(), int64_t{width} * height);
    width /= 2;
    height /= 2;
  }
}

TEST(Preprocessor, GivesTheSameBitsOnEveryDevice) {
  Calibration odd = small_calibration();
  odd.depth = {163, 121, 130, 129, 80.3, 61.1, {0.1, -0.2, 0.001, 0.002, 0.1}};
  odd.colour = {200, 150, 190, 188, 101, 73, {}};
  odd.T_colour_depth = pose_of({0, 1, 0}, {0.03, 0, 0});
  for (const Calibration& calibration : {small_calibration(), odd}) {
    const RgbdFrame frame = render(furnished_room(), calibration, pose_of({5, 10, 0}, {0.1, 0, 0}),
                                   {.noise_sigmas = 1, .seed = 9});
    const uint64_t reference = digest_of(Preprocessor(exec::Device::cpu(1), calibration, {}).process(frame));
    for (const exec::Device& device : parity_devices()) {
      EXPECT_EQ(digest_of(Preprocessor(device, calibration, {}).process(frame)), reference)
          << name_of(device);
    }
  }
}

TEST(Preprocessor, RemembersNothingOfTheFrameBefore) {
  const Calibration calibration = small_calibration();
  const RgbdFrame first = render(furnished_room(), calibration, Pose::Identity()),
                  second = render(furnished_room(), calibration, pose_of({0, 30, 0}, {0, 0, 0}));
  Preprocessor used(exec::Device::cpu(2), calibration, {}), fresh(exec::Device::cpu(2), calibration, {});
  used.process(first);
  EXPECT_EQ(digest_of(used.process(second)), digest_of(fresh.process(second)));
}

TEST(Preprocessor, OfAnEmptyFrameHasNothing) {
  const Calibration calibration = small_calibration();
  const HostMaps maps = preprocess(calibration, depth_frame(calibration.depth, [](int, int) { return 0; }));
  for (const HostLevel& level : maps.levels) {
    for (const Vec4f& n : level.normals) ASSERT_EQ(n.w, 0);
  }
  for (const FusionPixel& pixel : maps.fusion_pixels) ASSERT_EQ(pixel.weight(), 0);
}

TEST(Preprocessor, RefusesACalibrationThatMakesNoSense) {
  Calibration calibration = small_calibration();
  calibration.depth.fx = -128;
  try {
    Preprocessor(exec::Device::cpu(1), calibration, {});
    FAIL() << "must throw";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(),
                testing::AllOf(testing::HasSubstr("analytic"), testing::HasSubstr("fx is -128")));
  }
}

TEST(Preprocessor, RefusesImagesOfAnotherSize) {
  const Calibration calibration = small_calibration();
  Preprocessor preprocessor(exec::Device::cpu(1), calibration, {});
  RgbdFrame frame;
  frame.depth = Image<uint16_t>(160, 119);
  EXPECT_THROW(preprocessor.process(frame), LogicError);
  frame.depth = Image<uint16_t>(120, 160);  // as many pixels, turned
  EXPECT_THROW(preprocessor.process(frame), LogicError);
  frame.depth = Image<uint16_t>(160, 120);
  frame.colour = Image<Rgb8>(80, 60);
  EXPECT_THROW(preprocessor.process(frame), LogicError);
}

}  // namespace
}  // namespace kt::test
