// Frames of the analytic scene, exposed at will.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>

#include "offboard/exposure/exposure_view.h"
#include "tests/support/analytic_scene.h"

namespace kt::test {

/// Levels times a gain per channel, clipped as a camera clips them.
inline RgbdFrame exposed(RgbdFrame frame, const ChannelValues& gain) {
  const auto level = [](uint8_t value, double factor) {
    return static_cast<uint8_t>(std::min(255L, std::lround(factor * value)));
  };
  for (Rgb8& colour : frame.colour.pixels())
    colour = {level(colour.r, gain[0]), level(colour.g, gain[1]), level(colour.b, gain[2])};
  return frame;
}

inline ExposureView view_of(const RgbdFrame& frame, const Pose& T_world_camera,
                            const Calibration& calibration = small_calibration()) {
  Preprocessor preprocessor(exec::Device::cpu(1), calibration, {});
  return make_exposure_view(preprocessor.process(frame), T_world_camera);
}

}  // namespace kt::test
