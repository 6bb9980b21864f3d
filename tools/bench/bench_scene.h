// What the benches look at: closed-form scenes, a camera that moves through them, and the frames it sees.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "shared/types/calibration.h"
#include "shared/types/rgbd_frame.h"

namespace kt::bench {

enum class Scene {
  kRoom,     ///< a room with a ball in it; the camera sways in its middle
  kMission,  ///< an endless corridor with balls on both sides; the camera sways along it at 0.5 m/s
};

/// A camera of `width` x 3/4 `width` pixels that sees what a Kinect does, colour registered to depth.
Calibration rig_of(int width);

/// Camera at frame `index` of 30 per second; exact.
Pose pose_at(Scene scene, int index);

/// The exact frame there, of a surface with a texture that stays where it is; made by all cores.
RgbdFrame frame_at(Scene scene, int index, const Calibration& rig);

}  // namespace kt::bench
