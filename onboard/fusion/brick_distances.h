// How far each brick of a volume is from the nearest surface.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "onboard/fusion/brick_distance_kernel.h"
#include "shared/exec/buffer.h"
#include "shared/exec/device.h"

namespace kt {

class BrickDistances {
 public:
  BrickDistances(const exec::Device& device, int bricks)
      : device_(device),
        sets_{bricks},
        near_surface_(device, kFarthestBrick * sets_.words()),
        distances_(device, int64_t{sets_.rows()} * bricks) {}

  /// Of all bricks, from their states by slot.
  void measure(const uint8_t* brick_states);
  /// At most kFarthestBrick.
  const exec::Buffer<uint8_t>& by_slot() const { return distances_; }

 private:
  exec::Device device_;
  BrickSets sets_;
  exec::Buffer<uint64_t> near_surface_;  // the bricks within 0, 1, ... of surface
  exec::Buffer<uint8_t> distances_;
};

}  // namespace kt
