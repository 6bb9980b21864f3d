// The kernels that keep a frame's depth and make points of it again.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "onboard/preprocess/depth_map.h"
#include "shared/core/pinhole.h"

namespace kt {

struct CopyFloats {
  const float* from;
  float* to;
  KT_HOST_DEVICE void operator()(int64_t i) const { to[i] = from[i]; }
};

/// Points of the pixels that have a normal.
struct UnprojectDepth {
  DepthView depth;
  PinholeParams camera;
  const Vec4f* normals;
  Vec4f* points;  // out: in the camera (m), w = 1 where valid, else all 0

  KT_HOST_DEVICE void operator()(int u, int v) const {
    const int64_t i = int64_t{v} * camera.width + u;
    const float valid = normals[i].w;
    const Vec3f p = camera.unproject(static_cast<float>(u), static_cast<float>(v), depth.at(u, v));
    points[i] = {valid * p.x, valid * p.y, valid * p.z, valid};
  }
};

}  // namespace kt
