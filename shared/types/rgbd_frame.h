// One pair of depth and colour images as a source delivers it.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "shared/core/image.h"
#include "shared/types/effort.h"

namespace kt {

struct RgbdFrame {
  int64_t sequence = 0;             ///< counts the frames a source has delivered, from 0
  int64_t timestamp_us = 0;         ///< sensor clock of the depth image
  int64_t colour_timestamp_us = 0;  ///< sensor clock of the colour image
  Image<uint16_t> depth;            ///< depth camera; units of Calibration::depth_unit_m; 0 = no measurement
  Image<Rgb8> colour;               ///< colour camera; empty where the source has none
  Effort effort = Effort::kFull;    ///< of the mission that recorded it, which its replay repeats
};

}  // namespace kt
