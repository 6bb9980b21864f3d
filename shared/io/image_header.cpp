// Walks PNG chunks and JPEG segments: decoders may fill the missing half of a truncated image with grey and
// call it success, print warnings of their own, or allocate whatever a damaged header asks for.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/io/image_header.h"

#include <algorithm>
#include <cstring>
#include <string_view>
#include <zlib.h>

#include "shared/core/check.h"
#include "shared/io/file.h"

namespace kt {
namespace {

constexpr int64_t kMaxSide = 8192;
constexpr std::string_view kPngSignature = "\x89PNG\r\n\x1a\n";

class Walker {
 public:
  Walker(std::span<const uint8_t> bytes, const std::string& name) : bytes_(bytes), name_(name) {}

  ImageHeader png() {
    offset_ = kPngSignature.size();
    ImageHeader header;
    int channels = 0;
    bool has_pixels = false;
    while (true) {
      const uint32_t length = big_endian(4);
      const std::span<const uint8_t> chunk = take(size_t{4} + length);
      const std::string_view type = as_text(chunk.first(4));
      if (big_endian(4) != crc32(0, chunk.data(), static_cast<uInt>(chunk.size())))
        fail("is damaged (PNG checksum)");
      const bool first = channels == 0;
      if (first != (type == "IHDR") || (first && length != 13)) fail("is damaged (PNG header)");
      if (first) {
        const auto value = [&](size_t i) {
          return uint32_t{chunk[i]} << 24 | chunk[i + 1] << 16 | chunk[i + 2] << 8 | chunk[i + 3];
        };
        header.width = value(4);
        header.height = value(8);
        header.bits_per_channel = chunk[12];
        const int colour_type = chunk[13];
        header.is_grey = colour_type == 0;
        channels = colour_type == 2 ? 3 : colour_type == 4 ? 2 : colour_type == 6 ? 4 : 1;
      }
      has_pixels = has_pixels || type == "IDAT";
      if (type == "IEND") break;
    }
    if (!has_pixels) fail("is damaged (PNG without pixels)");
    check_size(header);
    // Deflate shrinks at most 1032-fold: a bigger image cannot be in these bytes.
    const double pixel_bytes =
        static_cast<double>(header.width * header.height * channels) * header.bits_per_channel / 8;
    if (pixel_bytes > 1032.0 * static_cast<double>(bytes_.size())) fail("is truncated or damaged");
    return header;
  }

  ImageHeader jpeg() {
    offset_ = 2;
    ImageHeader header{.format = ImageHeader::Format::kJpeg};
    while (true) {
      if (take(1)[0] != 0xff) fail("is damaged (JPEG marker)");
      uint8_t marker = take(1)[0];
      while (marker == 0xff) marker = take(1)[0];  // fill bytes
      if (marker == 0x01 || (marker >= 0xd0 && marker <= 0xd8)) continue;
      if (marker == 0xd9 || marker == 0x00) fail("is damaged (JPEG without pixels)");
      const uint32_t length = big_endian(2);
      if (length < 2) fail("is damaged (JPEG segment)");
      const std::span<const uint8_t> segment = take(length - 2);
      // SOF0 to SOF15 but for the tables DHT, JPG and DAC among them.
      if (marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc) {
        if (segment.size() < 6 || header.width != 0) fail("is damaged (JPEG frame header)");
        header.bits_per_channel = segment[0];
        header.height = segment[1] << 8 | segment[2];
        header.width = segment[3] << 8 | segment[4];
        header.is_grey = segment[5] == 1;
        check_size(header);
      }
      if (marker == 0xda) break;
    }
    if (header.width == 0) fail("is damaged (JPEG frame header)");
    // In entropy-coded pixels 0xff is followed by 0 or a restart marker, never by the end marker.
    constexpr uint8_t kEndOfImage[] = {0xff, 0xd9};
    const std::span<const uint8_t> rest = bytes_.subspan(offset_);
    if (std::search(rest.begin(), rest.end(), std::begin(kEndOfImage), std::end(kEndOfImage)) == rest.end())
      fail("is truncated");
    return header;
  }

  [[noreturn]] void fail(const std::string& what) const { throw Error(name_ + ": " + what); }

 private:
  std::span<const uint8_t> take(size_t count) {
    if (count > bytes_.size() - offset_) fail("is truncated");
    offset_ += count;
    return bytes_.subspan(offset_ - count, count);
  }
  uint32_t big_endian(size_t count) {
    uint32_t value = 0;
    for (const uint8_t byte : take(count)) value = value << 8 | byte;
    return value;
  }
  void check_size(const ImageHeader& header) const {
    if (header.width >= 1 && header.width <= kMaxSide && header.height >= 1 && header.height <= kMaxSide)
      return;
    fail(std::string("claims ") + std::to_string(header.width) + " x " + std::to_string(header.height) +
         " pixels; 1 to " + std::to_string(kMaxSide) + " a side are allowed");
  }

  std::span<const uint8_t> bytes_;
  const std::string& name_;
  size_t offset_ = 0;
};

}  // namespace

ImageHeader check_image(std::span<const uint8_t> bytes, const std::string& name) {
  Walker walker(bytes, name);
  if (bytes.empty()) walker.fail("is empty");
  if (as_text(bytes).starts_with(kPngSignature)) return walker.png();
  if (as_text(bytes).starts_with("\xff\xd8")) return walker.jpeg();
  walker.fail("is neither a PNG nor a JPEG image");
}

}  // namespace kt
