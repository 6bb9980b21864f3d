// The kernels that keep a frame's depth and make points of it again.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "onboard/preprocess/depth_map.h"
#include "shared/core/pinhole.h"
#include "shared/core/row_motion.h"

namespace kt {

struct CopyFloats {
  const float* from;
  float* to;
  KT_HOST_DEVICE void operator()(int64_t i) const { to[i] = from[i]; }
};

/// Points of the pixels that have a normal, in the camera at the time of the middle row.
struct UnprojectDepth {
  DepthView depth;
  PinholeParams camera;
  const Vec4f* normals;
  Vec4f* points;        // out: in the camera (m), w = 1 where valid, else all 0
  RowMotion shutter{};  // of `camera`

  KT_HOST_DEVICE void operator()(int u, int v) const {
    const int64_t i = int64_t{v} * camera.width + u;
    const float valid = normals[i].w;
    const auto row = static_cast<float>(v);
    const Vec3f p = shutter.to_middle(camera.unproject(static_cast<float>(u), row, depth.at(u, v)), row);
    points[i] = {valid * p.x, valid * p.y, valid * p.z, valid};
  }
};

}  // namespace kt
