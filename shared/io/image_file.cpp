// Image codecs behind the structure check of image_header.h.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/io/image_file.h"

#include "shared/core/check.h"
#include "shared/io/file.h"
#include "shared/io/image_header.h"
#include "shared/io/jpeg_codec.h"
#include "shared/io/png_codec.h"

namespace kt {

Image<uint16_t> decode_depth(std::span<const uint8_t> bytes, const std::string& name) {
  const ImageHeader header = check_image(bytes, name);
  if (header.format != ImageHeader::Format::kPng || !header.is_grey || header.bits_per_channel != 16) {
    throw Error(name + ": is not a depth image; 16-bit greyscale PNG is needed");
  }
  return decode_grey_png(bytes, header, name);
}

Image<Rgb8> decode_colour(std::span<const uint8_t> bytes, const std::string& name) {
  const ImageHeader header = check_image(bytes, name);
  if (header.bits_per_channel > 8) {
    throw Error(name + ": has more than 8 bits per channel; a colour image is needed");
  }
  return header.format == ImageHeader::Format::kJpeg ? decode_jpeg(bytes, header, name)
                                                     : decode_colour_png(bytes, header, name);
}

Image<uint16_t> read_depth(const std::filesystem::path& path) {
  return decode_depth(as_bytes(read_file(path)), path.string());
}

Image<Rgb8> read_colour(const std::filesystem::path& path) {
  return decode_colour(as_bytes(read_file(path)), path.string());
}

void write_depth(const std::filesystem::path& path, const Image<uint16_t>& depth) {
  write_file(path, as_text(encode_png(depth)));
}

void write_colour(const std::filesystem::path& path, const Image<Rgb8>& colour, int jpeg_quality) {
  const std::string extension = path.extension().string();
  if (extension == ".png") return write_file(path, as_text(encode_png(colour)));
  if (extension == ".jpg" || extension == ".jpeg") {
    return write_file(path, as_text(encode_jpeg(colour, jpeg_quality)));
  }
  throw Error(path.string() + ": colour images are written as .png, .jpg or .jpeg");
}

}  // namespace kt
