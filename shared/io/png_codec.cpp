// libspng, told to be quick.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/io/png_codec.h"

#include <cstdlib>
#include <memory>
#include <spng.h>
#include <zlib.h>

#include "shared/core/check.h"

namespace kt {
namespace {

using Context = std::unique_ptr<spng_ctx, decltype(&spng_ctx_free)>;

Context make_context(int flags) {
  Context context(spng_ctx_new(flags), spng_ctx_free);
  KT_CHECK(context, "no memory for libspng");
  return context;
}

template <typename Pixel>
Image<Pixel> decode(std::span<const uint8_t> bytes, const ImageHeader& header, spng_format format,
                    const std::string& name) {
  Image<Pixel> image(static_cast<int>(header.width), static_cast<int>(header.height));
  const Context png = make_context(0);
  int error = spng_set_png_buffer(png.get(), bytes.data(), bytes.size());
  if (error == 0) {
    const auto size = static_cast<size_t>(image.pixel_count()) * sizeof(Pixel);
    error = spng_decode_image(png.get(), image.data(), size, format, 0);
  }
  if (error != 0) throw Error(name + ": is damaged: " + spng_strerror(error));
  return image;
}

template <typename Pixel>
std::vector<uint8_t> encode(const Image<Pixel>& image, spng_color_type colour_type, int bits) {
  KT_CHECK(!image.empty());
  const Context png = make_context(SPNG_CTX_ENCODER);
  spng_ihdr header{};
  header.width = static_cast<uint32_t>(image.width());
  header.height = static_cast<uint32_t>(image.height());
  header.bit_depth = static_cast<uint8_t>(bits);
  header.color_type = static_cast<uint8_t>(colour_type);
  int error = spng_set_ihdr(png.get(), &header);
  const auto set = [&](spng_option option, int value) {
    if (error == 0) error = spng_set_option(png.get(), option, value);
  };
  set(SPNG_ENCODE_TO_BUFFER, 1);
  set(SPNG_IMG_COMPRESSION_LEVEL, Z_BEST_SPEED);
  set(SPNG_IMG_COMPRESSION_STRATEGY, Z_RLE);
  set(SPNG_FILTER_CHOICE, SPNG_FILTER_CHOICE_SUB);
  if (error == 0) {
    const auto size = static_cast<size_t>(image.pixel_count()) * sizeof(Pixel);
    error = spng_encode_image(png.get(), image.data(), size, SPNG_FMT_PNG, SPNG_ENCODE_FINALIZE);
  }
  size_t size = 0;
  const std::unique_ptr<void, decltype(&std::free)> bytes(
      error == 0 ? spng_get_png_buffer(png.get(), &size, &error) : nullptr, std::free);
  KT_CHECK(error == 0 && bytes, std::string("PNG: ") + spng_strerror(error));
  const auto* first = static_cast<const uint8_t*>(bytes.get());
  return {first, first + size};
}

}  // namespace

Image<uint16_t> decode_grey_png(std::span<const uint8_t> bytes, const ImageHeader& header,
                                const std::string& name) {
  return decode<uint16_t>(bytes, header, SPNG_FMT_PNG, name);  // in our byte order
}

Image<Rgb8> decode_colour_png(std::span<const uint8_t> bytes, const ImageHeader& header,
                              const std::string& name) {
  return decode<Rgb8>(bytes, header, SPNG_FMT_RGB8, name);
}

std::vector<uint8_t> encode_png(const Image<uint16_t>& grey) {
  return encode(grey, SPNG_COLOR_TYPE_GRAYSCALE, 16);
}

std::vector<uint8_t> encode_png(const Image<Rgb8>& colour) {
  return encode(colour, SPNG_COLOR_TYPE_TRUECOLOR, 8);
}

}  // namespace kt
