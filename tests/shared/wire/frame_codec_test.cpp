// Raw frames through compression: depth always exact, colour exact as PNG and close as JPEG.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/wire/frame_codec.h"

#include <cstdlib>
#include <gtest/gtest.h>

#include "shared/core/check.h"
#include "shared/core/rng.h"

namespace kt {
namespace {

RgbdFrame noisy_frame() {
  RgbdFrame frame{5, 1000, 1010, Image<uint16_t>(64, 48), Image<Rgb8>(80, 60)};
  for (int64_t i = 0; i < frame.depth.pixel_count(); ++i) {
    frame.depth.data()[i] = static_cast<uint16_t>(random_bits(1, 0, static_cast<uint64_t>(i)));
  }
  for (int v = 0; v < 60; ++v) {
    for (int u = 0; u < 80; ++u)
      frame.colour(u, v) = {static_cast<uint8_t>(3 * u), static_cast<uint8_t>(4 * v), 90};
  }
  return frame;
}

TEST(FrameCodec, LosslessColourIsExact) {
  const RgbdFrame frame = noisy_frame();
  const RgbdFrame back = decompress(compress(frame, {.lossless_colour = true}));
  EXPECT_EQ(back.sequence, 5);
  EXPECT_EQ(back.timestamp_us, 1000);
  EXPECT_EQ(back.colour_timestamp_us, 1010);
  EXPECT_EQ(back.depth, frame.depth);
  EXPECT_EQ(back.colour, frame.colour);
}

TEST(FrameCodec, JpegKeepsDepthExactAndColourClose) {
  const RgbdFrame frame = noisy_frame();
  const RgbdFrame back = decompress(compress(frame, {.jpeg_quality = 95}));
  EXPECT_EQ(back.depth, frame.depth);
  ASSERT_EQ(back.colour.pixel_count(), frame.colour.pixel_count());
  for (int64_t i = 0; i < frame.colour.pixel_count(); ++i) {
    const Rgb8 a = frame.colour.data()[i], b = back.colour.data()[i];
    ASSERT_LE(std::abs(a.r - b.r) + std::abs(a.g - b.g) + std::abs(a.b - b.b), 20) << "pixel " << i;
  }
}

TEST(FrameCodec, FrameWithoutColourStaysWithout) {
  RgbdFrame frame = noisy_frame();
  frame.colour = {};
  EXPECT_TRUE(decompress(compress(frame)).colour.empty());
}

TEST(FrameCodec, DamagedImageIsAnErrorThatNamesTheFrame) {
  CompressedFrame frame = compress(noisy_frame());
  frame.depth_png.resize(frame.depth_png.size() / 2);
  try {
    decompress(frame);
    FAIL() << "no error";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("raw frame 5, depth"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace kt
