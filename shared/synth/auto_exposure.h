// What a camera's automatic exposure and white balance make of a path through a scene.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include "shared/synth/renderer.h"
#include "shared/types/stamped_pose.h"

namespace kt {

/// Consumer cameras aim at a mean level of the whole image and, half way, at a grey mean; both follow with a
/// lag.
struct AutoExposure {
  double target = 0.2;  ///< mean linear light, times the gain
  double lowest = 0.4, highest = 2.5;
  double exposure_share =
      0.1;                    ///< of the way to the target that one frame goes: a lag of a third of a second
  double largest_tint = 1.4;  ///< of a channel against green, either way
  double balance_share = 0.03;  ///< the same for the white balance: a second
  int metering_stride = 3;      ///< every how many-th frame is metered
};

/// Gains on linear light, per channel, of frames 30 per second along the path. Metered on exact views of 40 x
/// 30 pixels; the first frame has reached its target.
std::vector<Vec3f> auto_exposure_gains(const Scene& scene, const Trajectory& T_world_camera,
                                       const AutoExposure& control = {});

}  // namespace kt
