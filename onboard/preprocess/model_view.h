// The model surface as predicted for one camera pose: what tracking aligns a frame to.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "shared/core/pinhole.h"
#include "shared/exec/buffer.h"
#include "shared/geometry/se3.h"

namespace kt {

/// Points and normals in the frame of the camera it was predicted for; lives on the device.
struct ModelView {
  PinholeParams camera;
  Pose T_odom_camera = Pose::Identity();
  /// The cube that the model can hold surface in: maps the camera to the middle of the cube, along its edges.
  Pose T_middle_camera = Pose::Identity();
  double half_edge_m = 1e9;
  exec::Buffer<Vec4f> points;   ///< (m), w = 1 where the ray hit, else all 0
  exec::Buffer<Vec4f> normals;  ///< unit, facing the camera, w = 1
};

}  // namespace kt
