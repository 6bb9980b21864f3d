// A depth image with a border of invalid pixels, so that filters need no special case at the rim.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "shared/core/host_device.h"

namespace kt {

/// Width of the border in pixels: the largest reach of any filter.
inline constexpr int kDepthBorder = 4;

/// Read access from kernels; (u, v) may lie up to kDepthBorder pixels outside. 0 = no measurement.
struct DepthView {
  const float* depth_m = nullptr;
  int32_t width = 0, height = 0;

  KT_HOST_DEVICE static int64_t padded_size(int width, int height) {
    return int64_t{width + 2 * kDepthBorder} * (height + 2 * kDepthBorder);
  }
  KT_HOST_DEVICE int64_t index(int u, int v) const {
    return int64_t{v + kDepthBorder} * (width + 2 * kDepthBorder) + (u + kDepthBorder);
  }
  KT_HOST_DEVICE float at(int u, int v) const { return depth_m[index(u, v)]; }
};

/// Standard deviation (m) of a structured-light depth measurement at range z (m), axial part of Nguyen et al.
/// 2012, eq. 4.
KT_HOST_DEVICE inline float depth_sigma_m(float z) { return 0.0012f + 0.0019f * (z - 0.4f) * (z - 0.4f); }

}  // namespace kt
