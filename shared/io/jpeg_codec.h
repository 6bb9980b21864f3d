// JPEG through libjpeg itself, whose warnings about missing pixels other libraries print and ignore.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "shared/core/image.h"
#include "shared/io/image_header.h"

namespace kt {

/// `header` as check_image found it in the same bytes. Throws kt::Error naming `name` where pixels are
/// missing or damaged so that the decoder notices. Leftover bytes, which many cameras leave, are no damage.
Image<Rgb8> decode_jpeg(std::span<const uint8_t> bytes, const ImageHeader& header, const std::string& name);

/// `quality` from 1 to 100; colours at half the resolution (4:2:0).
std::vector<uint8_t> encode_jpeg(const Image<Rgb8>& colour, int quality = 95);

}  // namespace kt
