// Views of a synthetic world by a camera that is led around what it looks at.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "shared/synth/mission.h"

namespace kt {

/// T_world_camera turned about the vertical line through the point `ahead_m` before the camera.
Pose orbited(const Pose& T_world_camera, double ahead_m, double angle_rad);

/// What the mission's camera would deliver from there, sharp and at usual exposure; `number` chooses the
/// noise and becomes the frame's sequence.
RgbdFrame render_at(const SyntheticMission& mission, const Pose& T_world_camera, int64_t number);

/// Whether the camera stands free: hardly anything lies nearer than its depth sensor sees.
bool stands_free(const SyntheticMission& mission, const Pose& T_world_camera);

}  // namespace kt
