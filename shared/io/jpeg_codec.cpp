// libjpeg with an error handler that keeps quiet and takes damaged pixels for what they are. Between setjmp
// and longjmp no object with a destructor may be made: hence functions of plain values.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/io/jpeg_codec.h"

#include <csetjmp>
#include <cstdio>  // jpeglib.h needs it first
#include <cstdlib>
#include <jerror.h>
#include <jpeglib.h>
#include <memory>

#include "shared/core/check.h"

namespace kt {
namespace {

struct ErrorHandler {
  jpeg_error_mgr base;  // first, so that libjpeg's pointer to it is a pointer to us
  std::jmp_buf jump;
  char message[JMSG_LENGTH_MAX];
};

void give_up(j_common_ptr jpeg) {
  auto* handler = reinterpret_cast<ErrorHandler*>(jpeg->err);
  handler->base.format_message(jpeg, handler->message);
  std::longjmp(handler->jump, 1);
}

void judge_message(j_common_ptr jpeg, int level) {
  if (level >= 0) return;  // a trace, not a warning
  const int code = jpeg->err->msg_code;
  const bool is_harmless =
      code == JWRN_EXTRANEOUS_DATA || code == JWRN_JFIF_MAJOR || code == JWRN_ADOBE_XFORM;
  if (!is_harmless) give_up(jpeg);
}

jpeg_error_mgr* quiet(ErrorHandler& handler) {
  jpeg_error_mgr* errors = jpeg_std_error(&handler.base);
  errors->error_exit = give_up;
  errors->emit_message = judge_message;
  return errors;
}

/// False where libjpeg gave up.
bool decode_rows(jpeg_decompress_struct& jpeg, ErrorHandler& handler, std::span<const uint8_t> bytes,
                 Rgb8* pixels, JDIMENSION width, JDIMENSION height) {
  if (setjmp(handler.jump)) return false;
  jpeg_create_decompress(&jpeg);
  jpeg_mem_src(&jpeg, bytes.data(), static_cast<unsigned long>(bytes.size()));
  jpeg_read_header(&jpeg, TRUE);
  jpeg.out_color_space = JCS_RGB;
  jpeg_start_decompress(&jpeg);
  if (jpeg.output_width != width || jpeg.output_height != height) return false;
  while (jpeg.output_scanline < height) {
    JSAMPROW row = reinterpret_cast<JSAMPROW>(pixels + size_t{jpeg.output_scanline} * width);
    jpeg_read_scanlines(&jpeg, &row, 1);
  }
  jpeg_finish_decompress(&jpeg);
  return true;
}

/// False where libjpeg gave up. `bytes`, if not null, is the caller's to free.
bool encode_rows(jpeg_compress_struct& jpeg, ErrorHandler& handler, const Rgb8* pixels, JDIMENSION width,
                 JDIMENSION height, int quality, unsigned char** bytes, unsigned long* size) {
  if (setjmp(handler.jump)) return false;
  jpeg_create_compress(&jpeg);
  jpeg_mem_dest(&jpeg, bytes, size);
  jpeg.image_width = width;
  jpeg.image_height = height;
  jpeg.input_components = 3;
  jpeg.in_color_space = JCS_RGB;
  jpeg_set_defaults(&jpeg);
  jpeg_set_quality(&jpeg, quality, TRUE);
  jpeg_start_compress(&jpeg, TRUE);
  while (jpeg.next_scanline < height) {
    JSAMPROW row = reinterpret_cast<JSAMPROW>(const_cast<Rgb8*>(pixels) + size_t{jpeg.next_scanline} * width);
    jpeg_write_scanlines(&jpeg, &row, 1);
  }
  jpeg_finish_compress(&jpeg);
  return true;
}

}  // namespace

Image<Rgb8> decode_jpeg(std::span<const uint8_t> bytes, const ImageHeader& header, const std::string& name) {
  Image<Rgb8> colour(static_cast<int>(header.width), static_cast<int>(header.height));
  ErrorHandler handler{};
  jpeg_decompress_struct jpeg{};
  jpeg.err = quiet(handler);
  const bool decoded = decode_rows(jpeg, handler, bytes, colour.data(), static_cast<JDIMENSION>(header.width),
                                   static_cast<JDIMENSION>(header.height));
  jpeg_destroy_decompress(&jpeg);
  if (!decoded) throw Error(name + ": is damaged: " + handler.message);
  return colour;
}

std::vector<uint8_t> encode_jpeg(const Image<Rgb8>& colour, int quality) {
  KT_CHECK(!colour.empty() && quality >= 1 && quality <= 100);
  ErrorHandler handler{};
  jpeg_compress_struct jpeg{};
  jpeg.err = quiet(handler);
  unsigned char* data = nullptr;
  unsigned long size = 0;
  const bool encoded = encode_rows(jpeg, handler, colour.data(), static_cast<JDIMENSION>(colour.width()),
                                   static_cast<JDIMENSION>(colour.height()), quality, &data, &size);
  jpeg_destroy_compress(&jpeg);
  const std::unique_ptr<unsigned char, decltype(&std::free)> owner(data, std::free);
  KT_CHECK(encoded, std::string("JPEG: ") + handler.message);
  return {data, data + size};
}

}  // namespace kt
