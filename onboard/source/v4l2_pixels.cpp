// Turns rows of pixels round into ours; JPEG goes to its decoder.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/source/v4l2_pixels.h"

#include <cstring>
#include <opencv2/imgproc.hpp>

#include "shared/core/check.h"
#include "shared/io/image_file.h"

namespace kt {
namespace {

void check_length(const V4l2Format& format, size_t row_bytes, size_t bytes) {
  const auto rows = static_cast<size_t>(format.size.height);
  const size_t needed = rows == 0 ? 0 : (rows - 1) * static_cast<size_t>(format.bytes_per_line) + row_bytes;
  if (bytes < needed)
    throw Error("cut off after " + std::to_string(bytes) + " of " + std::to_string(needed) + " bytes");
}

template <typename T>
Image<T> packed_rows(const V4l2Format& format, std::span<const uint8_t> bytes) {
  Image<T> image(format.size.width, format.size.height);
  const size_t row_bytes = static_cast<size_t>(format.size.width) * sizeof(T);
  check_length(format, row_bytes, bytes.size());
  for (int v = 0; v < image.height(); ++v) {
    std::memcpy(image.data() + static_cast<ptrdiff_t>(v) * image.width(),
                bytes.data() + static_cast<ptrdiff_t>(v) * format.bytes_per_line, row_bytes);
  }
  return image;
}

}  // namespace

Image<uint16_t> depth_image(const V4l2Format& format, std::span<const uint8_t> bytes) {
  return packed_rows<uint16_t>(format, bytes);  // Z16 is little endian, as we are
}

Image<Rgb8> colour_image(const V4l2Format& format, std::span<const uint8_t> bytes) {
  const auto [width, height] = format.size;
  switch (format.format) {
    case PixelFormat::kRgb24:
      return packed_rows<Rgb8>(format, bytes);
    case PixelFormat::kYuyv: {
      check_length(format, 2 * static_cast<size_t>(width), bytes.size());
      Image<Rgb8> image(width, height);
      const cv::Mat from(height, width, CV_8UC2, const_cast<uint8_t*>(bytes.data()),
                         static_cast<size_t>(format.bytes_per_line));
      cv::Mat to(height, width, CV_8UC3, image.data());
      cv::cvtColor(from, to, cv::COLOR_YUV2RGB_YUY2);
      return image;
    }
    case PixelFormat::kMjpeg: {
      Image<Rgb8> image = decode_colour(bytes, "JPEG image");
      if (image.width() != width || image.height() != height) throw Error("a JPEG image of another size");
      return image;
    }
    case PixelFormat::kZ16:
      break;
  }
  throw Error("depth is no colour");
}

}  // namespace kt
