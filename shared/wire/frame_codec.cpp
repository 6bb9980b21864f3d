// Compresses raw frames with the image codecs of shared/io.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/wire/frame_codec.h"

#include <string>

#include "shared/io/image_file.h"
#include "shared/io/jpeg_codec.h"
#include "shared/io/png_codec.h"

namespace kt {

CompressedFrame compress(const RgbdFrame& frame, const FrameCompression& compression) {
  CompressedFrame compressed{
      frame.sequence, frame.timestamp_us, frame.colour_timestamp_us, encode_png(frame.depth), {}};
  if (!frame.colour.empty()) {
    compressed.colour = compression.lossless_colour ? encode_png(frame.colour)
                                                    : encode_jpeg(frame.colour, compression.jpeg_quality);
  }
  return compressed;
}

RgbdFrame decompress(const CompressedFrame& frame) {
  const std::string name = "raw frame " + std::to_string(frame.sequence);
  RgbdFrame raw{frame.sequence,
                frame.timestamp_us,
                frame.colour_timestamp_us,
                decode_depth(frame.depth_png, name + ", depth"),
                {}};
  if (!frame.colour.empty()) raw.colour = decode_colour(frame.colour, name + ", colour");
  return raw;
}

}  // namespace kt
