// libjpeg with an error handler that keeps quiet and takes damaged pixels for what they are.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/io/jpeg_decoder.h"

#include <csetjmp>
#include <cstdio>  // jpeglib.h needs it first
#include <jerror.h>
#include <jpeglib.h>

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

/// False where libjpeg gave up. Between setjmp and longjmp no object with a destructor may be made: hence a
/// function of plain values.
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

}  // namespace

Image<Rgb8> decode_jpeg(std::span<const uint8_t> bytes, const ImageHeader& header, const std::string& name) {
  Image<Rgb8> colour(static_cast<int>(header.width), static_cast<int>(header.height));
  ErrorHandler handler{};
  jpeg_decompress_struct jpeg{};
  jpeg.err = jpeg_std_error(&handler.base);
  handler.base.error_exit = give_up;
  handler.base.emit_message = judge_message;
  const bool decoded = decode_rows(jpeg, handler, bytes, colour.data(), static_cast<JDIMENSION>(header.width),
                                   static_cast<JDIMENSION>(header.height));
  jpeg_destroy_decompress(&jpeg);
  if (!decoded) throw Error(name + ": is damaged: " + handler.message);
  return colour;
}

}  // namespace kt
