// Tests of keyframes made of rendered frames.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/loops/keyframe_maker.h"

#include "gtest/gtest.h"

#include "tests/support/analytic_scene.h"

namespace kt::test {
namespace {

Keyframe keyframe_of(double gain, PlaceFeature feature) {
  const Calibration calibration = small_calibration(2);
  RgbdFrame frame = render(furnished_room(), calibration, Pose::Identity(), {.blotches_m = 0.12});
  const auto darker = [gain](uint8_t level) { return static_cast<uint8_t>(gain * level + 0.5); };
  for (Rgb8& c : frame.colour.pixels()) c = {darker(c.r), darker(c.g), darker(c.b)};
  Preprocessor preprocessor(exec::Device::cpu(1), calibration, {});
  KeyframeMaker maker(calibration, feature);
  return maker.make(KeyframeMaker::images_of(preprocessor.process(frame), frame.colour, {}));
}

TEST(KeyframeMaker, ADarkImageHasNearlyAsManyKeypoints) {
  for (const PlaceFeature feature : {PlaceFeature::kSurf, PlaceFeature::kCorners}) {
    const size_t bright = keyframe_of(1, feature).u_px.size();
    ASSERT_GT(bright, 100u);
    EXPECT_GT(keyframe_of(0.25, feature).u_px.size(), bright / 2);
    EXPECT_GT(keyframe_of(0.12, feature).u_px.size(), bright * 2 / 5);
    EXPECT_EQ(keyframe_of(0, feature).u_px.size(), 0u);
  }
}

TEST(KeyframeMaker, KeypointsLieOnWhatTheyShow) {
  const Calibration calibration = small_calibration(2);
  const Keyframe keyframe = keyframe_of(1, PlaceFeature::kSurf);
  int measured = 0;
  for (size_t i = 0; i < keyframe.u_px.size(); ++i) {
    const Vec3f p = keyframe.p_camera[i];
    if (p.z <= 0) continue;
    ++measured;
    const Eigen::Vector3d p_colour = calibration.T_colour_depth * Eigen::Vector3d(p.x, p.y, p.z);
    const PinholeParams camera = calibration.colour.pinhole();
    EXPECT_NEAR(keyframe.u_px[i], camera.fx * p_colour.x() / p_colour.z() + camera.cx, 1.0);
    EXPECT_NEAR(keyframe.v_px[i], camera.fy * p_colour.y() / p_colour.z() + camera.cy, 1.0);
  }
  EXPECT_GT(measured, 100);
}

}  // namespace
}  // namespace kt::test
