// Decodes JPEG by libjpeg itself: OpenCV prints what is wrong with one and returns it half grey.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "shared/core/image.h"
#include "shared/io/image_header.h"

namespace kt {

/// `header` as check_image found it in the same bytes. Throws kt::Error naming `name` where pixels are
/// missing or damaged so that the decoder notices. Leftover bytes, which many cameras leave, are no damage.
Image<Rgb8> decode_jpeg(std::span<const uint8_t> bytes, const ImageHeader& header, const std::string& name);

}  // namespace kt
