// Frames of a camera in an unsteady hand, which sees nothing new.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <vector>

#include "tests/support/analytic_scene.h"

namespace kt::test {

/// Of the tests of allocations: frames to warm up with, and frames that count.
inline constexpr int kWarmUp = 40, kCounted = 100;

inline std::vector<RgbdFrame> unsteady_frames(int count) {
  std::vector<RgbdFrame> frames;
  for (int i = 0; i < count; ++i) {
    const double t = 0.15 * i;
    const Pose T_world_camera =
        pose_of({1.5 * std::sin(t), std::sin(0.7 * t), 0}, {0.03 * std::sin(0.8 * t), 0.02 * std::sin(t), 0});
    frames.push_back(render(furnished_room(), small_calibration(), T_world_camera,
                            {.noise_sigmas = 0.5, .seed = 1, .sequence = i}));
  }
  return frames;
}

}  // namespace kt::test
