// How much work a frame gets: all of it, or less where the mission cannot keep up.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

namespace kt {

/// Each leaves out what the one before it leaves out, and more.
enum class Effort : uint8_t {
  kFull = 0,
  kSparseFusion = 1,    ///< only every second frame is fused, and the model predicted from it
  kCoarseTracking = 2,  ///< frames are aligned at a quarter of the resolution alone
};
inline constexpr int kEfforts = 3;

/// "full", "sparse fusion" or "coarse tracking".
const char* to_string(Effort effort);

}  // namespace kt
