// Kernels that tell how far each brick is from the nearest surface, so that rays can leap over empty space.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "onboard/fusion/grid.h"

namespace kt {

/// Distances between bricks are Chebyshev's, in bricks, and end here: a brick at it has no surface nearer.
inline constexpr int kFarthestBrick = 4;

/// 0 for bricks that hold surface, else kFarthestBrick; by slot.
struct StartBrickDistance {
  const uint8_t* brick_states;
  uint8_t* distances;  // out

  KT_HOST_DEVICE void operator()(int64_t slot) const {
    distances[slot] = brick_states[slot] == kBrickSurface ? 0 : kFarthestBrick;
  }
};

/// One axis of one round of the distance transform: the least of a brick and its two neighbours along the
/// axis; by row of bricks along x. After x, y and z that is the least of 27 bricks, and one more than it
/// bounds the distance: kFarthestBrick - 1 rounds make every distance exact. Bricks are taken in ring order,
/// where the first and the last of an axis are neighbours too; that can only shorten a distance.
struct SpreadBrickDistance {
  int32_t bricks;  // per axis
  int32_t axis;
  const uint8_t* input;
  const uint8_t* before;  // distances before this round; null but for the last axis
  uint8_t* output;        // may be `before`

  KT_HOST_DEVICE void operator()(int64_t row) const {
    const int y = static_cast<int>(row % bricks), z = static_cast<int>(row / bricks);
    const uint8_t* here = input + row * bricks;
    uint8_t* out = output + row * bricks;
    if (axis == 0) {
      for (int x = 1; x < bricks - 1; ++x) out[x] = least(here[x - 1], here[x], here[x + 1]);
      out[0] = least(here[bricks - 1], here[0], here[1]);
      out[bricks - 1] = least(here[bricks - 2], here[bricks - 1], here[0]);
      return;
    }
    const int64_t last = bricks - 1;
    const int64_t step = axis == 1 ? bricks : int64_t{bricks} * bricks;
    const int at = axis == 1 ? y : z;
    const uint8_t* previous = here + (at > 0 ? -step : last * step);
    const uint8_t* next = here + (at < last ? step : -last * step);
    if (!before) {
      for (int x = 0; x < bricks; ++x) out[x] = least(previous[x], here[x], next[x]);
      return;
    }
    const uint8_t* old = before + row * bricks;
    for (int x = 0; x < bricks; ++x) {
      const auto bound = static_cast<uint8_t>(least(previous[x], here[x], next[x]) + 1);
      out[x] = old[x] < bound ? old[x] : bound;
    }
  }

 private:
  KT_HOST_DEVICE static uint8_t least(uint8_t a, uint8_t b, uint8_t c) {
    const uint8_t ab = a < b ? a : b;
    return ab < c ? ab : c;
  }
};

}  // namespace kt
