// Depth images as 16-bit PNG, colour images as 8-bit PNG or JPEG, in files and in memory.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

#include "shared/core/image.h"

namespace kt {

/// Every decoder throws kt::Error naming `name` where the bytes are no such image, of another bit depth,
/// truncated, or larger than 8192 x 8192. A damaged image is never returned half-filled.
Image<uint16_t> decode_depth(std::span<const uint8_t> bytes, const std::string& name);
/// PNG or JPEG; grey images become colour, alpha is dropped, EXIF orientation is ignored: pixels stay where
/// the sensor had them.
Image<Rgb8> decode_colour(std::span<const uint8_t> bytes, const std::string& name);

Image<uint16_t> read_depth(const std::filesystem::path& path);
Image<Rgb8> read_colour(const std::filesystem::path& path);

void write_depth(const std::filesystem::path& path, const Image<uint16_t>& depth);
/// PNG or JPEG by the extension: .png, .jpg or .jpeg.
void write_colour(const std::filesystem::path& path, const Image<Rgb8>& colour, int jpeg_quality = 95);

}  // namespace kt
