// Kernel that brings the registered colour of a frame to another exposure.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "shared/core/host_device.h"
#include "shared/core/vec.h"

namespace kt {

/// From this level on a channel may have been clipped: what is known is a lower bound.
inline constexpr int32_t kClippedLevel = 250;
/// Trust in a colour with a clipped channel, of 255: it shows where no view has a better one.
inline constexpr uint32_t kClippedTrust = 16;

/// level' = min(factor * level, 255), rounded, per channel; an 8-bit curve close to a power law turns a
/// factor of the light into one of the levels. The trust (a) of clipped colours falls to kClippedTrust.
/// Pixels without colour (a = 0) stay so.
struct CorrectColour {
  Vec3f factor;       // > 0
  uint32_t* colours;  // in, out: rgba

  KT_HOST_DEVICE void operator()(int64_t i) const {
    const uint32_t rgba = colours[i];
    const auto r = static_cast<int32_t>(rgba & 255), g = static_cast<int32_t>(rgba >> 8 & 255),
               b = static_cast<int32_t>(rgba >> 16 & 255);
    const bool clipped = r >= kClippedLevel || g >= kClippedLevel || b >= kClippedLevel;
    const uint32_t trust = clipped ? kClippedTrust : 255u;
    const uint32_t corrected = scaled(r, factor.x) | scaled(g, factor.y) << 8 | scaled(b, factor.z) << 16;
    colours[i] = rgba >> 24 ? corrected | trust << 24 : 0u;
  }

 private:
  KT_HOST_DEVICE static uint32_t scaled(int32_t level, float factor) {
    const float value = static_cast<float>(level) * factor + 0.5f;
    return static_cast<uint32_t>(static_cast<int32_t>(value < 255.0f ? value : 255.0f));
  }
};

}  // namespace kt
