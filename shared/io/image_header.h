// Looks at the structure of PNG and JPEG bytes before a decoder trusts them.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <string>

namespace kt {

struct ImageHeader {
  enum class Format { kPng, kJpeg };
  Format format = Format::kPng;
  int64_t width = 0, height = 0;
  int bits_per_channel = 0;
  bool is_grey = false;
};

/// Checks that every PNG chunk is whole and has its checksum, or that the JPEG has its markers up to the end
/// of the image, and that the size is sane. Throws kt::Error naming `name` otherwise.
ImageHeader check_image(std::span<const uint8_t> bytes, const std::string& name);

}  // namespace kt
