// Images of Video4Linux formats as images of ours.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "onboard/source/v4l2_stream.h"
#include "shared/core/image.h"

namespace kt {

/// `bytes` as the driver gave them; throw kt::Error where they are too few or no such image.
Image<uint16_t> depth_image(const V4l2Format& format, std::span<const uint8_t> bytes);
/// YUYV as BT.601 with the video range, what UVC cameras send.
Image<Rgb8> colour_image(const V4l2Format& format, std::span<const uint8_t> bytes);

}  // namespace kt
