// Frames of a small camera.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "shared/io/calibration_file.h"
#include "shared/types/rgbd_frame.h"

namespace kt {

inline Calibration small_calibration() {
  Calibration calibration = builtin_calibration("synthetic");
  calibration.depth =
      calibration.colour = {.width = 64, .height = 48, .fx = 52.5, .fy = 52.5, .cx = 31.5, .cy = 23.5};
  calibration.invalid_depth = 65535;
  return calibration;
}

inline RgbdFrame small_frame(int64_t stamp_us) {
  return {.timestamp_us = stamp_us,
          .colour_timestamp_us = stamp_us,
          .depth = Image<uint16_t>(64, 48, uint16_t{5000}),
          .colour = Image<Rgb8>(64, 48, Rgb8{9, 9, 9})};
}

}  // namespace kt
