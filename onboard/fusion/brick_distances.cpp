// Sets of bricks that are spread brick by brick, and from them the distances.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/fusion/brick_distances.h"

#include "shared/exec/for_each.h"

namespace kt {

void BrickDistances::measure(const uint8_t* brick_states) {
  const int words = sets_.words_per_row();
  uint64_t* set = near_surface_.data();
  exec::for_each_pixel(device_, words, sets_.rows(), FindSurfaceBricks{sets_, brick_states, set});
  for (int distance = 1; distance < kFarthestBrick; ++distance) {
    uint64_t* const before = set;
    set += sets_.words();
    exec::for_each_pixel(device_, words, sets_.rows(), SpreadBricks{sets_, before, set});
  }
  exec::for_each_pixel(device_, sets_.bricks / kBlockSide, sets_.rows(),
                       MeasureBrickDistance{sets_, near_surface_.data(), distances_.data()});
}

}  // namespace kt
