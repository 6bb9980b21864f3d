// PNG through libspng.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "shared/core/image.h"
#include "shared/io/image_header.h"

namespace kt {

/// `header` as check_image found it in the same bytes; of 16-bit grey pixels here, of at most 8 bits below.
/// Throws kt::Error naming `name` where the pixels cannot be decoded whole.
Image<uint16_t> decode_grey_png(std::span<const uint8_t> bytes, const ImageHeader& header,
                                const std::string& name);
/// Grey and palettes become colour, alpha is dropped.
Image<Rgb8> decode_colour_png(std::span<const uint8_t> bytes, const ImageHeader& header,
                              const std::string& name);

/// Lossless, and set for speed: neighbour differences and run lengths, no choice of a filter for each row.
std::vector<uint8_t> encode_png(const Image<uint16_t>& grey);
std::vector<uint8_t> encode_png(const Image<Rgb8>& colour);

}  // namespace kt
