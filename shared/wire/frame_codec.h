// Raw frames to compressed ones and back.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "shared/types/rgbd_frame.h"
#include "shared/wire/compressed_frame.h"

namespace kt {

/// How colour travels; depth is always lossless PNG.
struct FrameCompression {
  bool lossless_colour = false;  ///< PNG instead of JPEG
  int jpeg_quality = 95;         ///< 1 to 100
};

CompressedFrame compress(const RgbdFrame& frame, const FrameCompression& compression = {});

/// Throws kt::Error where an image is damaged or of the wrong kind.
RgbdFrame decompress(const CompressedFrame& frame);

}  // namespace kt
