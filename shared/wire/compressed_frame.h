// A raw frame as it travels: depth and colour as image files in memory.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

namespace kt {

/// RgbdFrame with its images compressed; see frame_codec.h.
struct CompressedFrame {
  int64_t sequence = 0;             ///< as RgbdFrame
  int64_t timestamp_us = 0;         ///< as RgbdFrame
  int64_t colour_timestamp_us = 0;  ///< as RgbdFrame
  std::vector<uint8_t> depth_png;   ///< 16-bit PNG, lossless
  std::vector<uint8_t> colour;      ///< JPEG or PNG; empty where the source has no colour
};

}  // namespace kt
