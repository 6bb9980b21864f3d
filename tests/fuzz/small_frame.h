// A raw frame of a few pixels, to begin with.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "shared/types/rgbd_frame.h"

namespace kt {

inline RgbdFrame small_frame(int64_t sequence) {
  RgbdFrame frame{sequence, 33333 * sequence, 33333 * sequence, Image<uint16_t>(16, 16, uint16_t{1000}),
                  Image<Rgb8>(16, 16, Rgb8{10, 20, 30})};
  frame.depth(3, 4) = 65535;
  return frame;
}

}  // namespace kt
