// Odometry as a robot on wheels would measure it along a synthetic mission: exact steps, and drift.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "shared/synth/mission.h"
#include "shared/types/motion_sample.h"

namespace kt {

/// What is wrong with the wheels. The sigmas are those of the white noise, and what the samples state; the
/// systematic part outgrows them: at half a metre per second after some seconds, as with real wheels.
struct WheelFlaws {
  double scale_error = 0.02;        ///< lengths are longer by this share
  double yaw_drift_rps = 0.002;     ///< about the vertical of the world (rad/s)
  double rotation_sigma = 0.01;     ///< rad per square root of a second
  double translation_sigma = 0.02;  ///< m per square root of a second
};

/// 50 pose samples per second from the first frame to the last, in a frame that begins at the first camera.
/// They depend on the mission's path and the flaws alone.
std::vector<MotionSample> wheel_odometry(const SyntheticMission& mission, const WheelFlaws& flaws = {});

}  // namespace kt
