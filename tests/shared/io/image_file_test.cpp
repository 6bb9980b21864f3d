// Image codecs: lossless round trips, and every kind of damage is an error.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/io/image_file.h"

#include <algorithm>
#include <cstdlib>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <zlib.h>

#include "shared/core/rng.h"
#include "shared/io/file.h"
#include "shared/io/jpeg_codec.h"
#include "shared/io/png_codec.h"
#include "tests/support/test_files.h"

namespace kt {
namespace {

using ::testing::HasSubstr;

Image<uint16_t> depth_image(int width = 64, int height = 48) {
  Image<uint16_t> depth(width, height);
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u)
      depth(u, v) = static_cast<uint16_t>(1000 + 700 * u + random_bits(1, u, v) % 9);
  }
  return depth;
}

Image<Rgb8> colour_image(int width = 64, int height = 48) {
  Image<Rgb8> colour(width, height);
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u)
      colour(u, v) = {static_cast<uint8_t>(4 * u), static_cast<uint8_t>(5 * v), 30};
  }
  return colour;
}

void add_chunk(std::vector<uint8_t>& png, std::string_view type, std::span<const uint8_t> content) {
  const auto big_endian = [&](uint32_t value) {
    for (int shift = 24; shift >= 0; shift -= 8) png.push_back(static_cast<uint8_t>(value >> shift));
  };
  big_endian(static_cast<uint32_t>(content.size()));
  const size_t start = png.size();
  png.insert(png.end(), type.begin(), type.end());
  png.insert(png.end(), content.begin(), content.end());
  big_endian(static_cast<uint32_t>(crc32(0, png.data() + start, static_cast<uInt>(png.size() - start))));
}

/// A PNG as others write them; `rows` as they stand in the file, each after its filter byte.
std::vector<uint8_t> foreign_png(int width, int height, int bits, int colour_type,
                                 const std::vector<uint8_t>& rows, const std::vector<uint8_t>& palette = {}) {
  std::vector<uint8_t> png = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
  add_chunk(png, "IHDR",
            std::vector<uint8_t>{0, 0, 0, static_cast<uint8_t>(width), 0, 0, 0, static_cast<uint8_t>(height),
                                 static_cast<uint8_t>(bits), static_cast<uint8_t>(colour_type), 0, 0, 0});
  if (!palette.empty()) add_chunk(png, "PLTE", palette);
  uLongf size = compressBound(rows.size());
  std::vector<uint8_t> pixels(size);
  EXPECT_EQ(compress(pixels.data(), &size, rows.data(), rows.size()), Z_OK);
  add_chunk(png, "IDAT", std::span(pixels).first(size));
  add_chunk(png, "IEND", {});
  return png;
}

TEST(ImageFile, PngIsLossless) {
  EXPECT_EQ(decode_depth(encode_png(depth_image()), "d"), depth_image());
  EXPECT_EQ(decode_colour(encode_png(colour_image()), "c"), colour_image());
}

TEST(ImageFile, PngsOfOthersAreRead) {
  const Image<uint16_t> depth =
      decode_depth(foreign_png(2, 2, 16, 0, {0, 0x12, 0x34, 0, 0, 2, 0, 1, 0xff, 0xff}), "d");
  EXPECT_EQ(depth(0, 0), 0x1234);
  EXPECT_EQ(depth(1, 0), 0);
  EXPECT_EQ(depth(0, 1), 0x1235) << "filter 2: the difference from the row above";
  EXPECT_EQ(depth(1, 1), 0xffff);
  const Image<Rgb8> grey = decode_colour(foreign_png(2, 1, 8, 0, {0, 7, 200}), "grey");
  EXPECT_EQ(grey(1, 0), (Rgb8{200, 200, 200}));
  const Image<Rgb8> black_and_white = decode_colour(foreign_png(2, 1, 1, 0, {0, 0x40}), "1 bit");
  EXPECT_EQ(black_and_white(0, 0), (Rgb8{0, 0, 0}));
  EXPECT_EQ(black_and_white(1, 0), (Rgb8{255, 255, 255}));
  const Image<Rgb8> palette =
      decode_colour(foreign_png(2, 1, 8, 3, {0, 1, 0}, {10, 20, 30, 40, 50, 60}), "palette");
  EXPECT_EQ(palette(0, 0), (Rgb8{40, 50, 60}));
  EXPECT_EQ(palette(1, 0), (Rgb8{10, 20, 30}));
  const Image<Rgb8> alpha = decode_colour(foreign_png(1, 1, 8, 6, {0, 1, 2, 3, 0}), "alpha");
  EXPECT_EQ(alpha(0, 0), (Rgb8{1, 2, 3})) << "alpha is dropped, not applied";
}

TEST(ImageFile, PngPixelsThatEndEarlyAreAnError) {
  EXPECT_THAT(error_of([] {
                decode_depth(foreign_png(2, 2, 16, 0, {0, 0x12, 0x34, 0, 0, 2, 0, 1}), "d.png");
              }),
              HasSubstr("d.png: is damaged"));
}

TEST(ImageFile, JpegIsClose) {
  const Image<Rgb8> original = colour_image(), decoded = decode_colour(encode_jpeg(original), "c");
  ASSERT_EQ(decoded.pixel_count(), original.pixel_count());
  int64_t difference = 0;
  for (int64_t i = 0; i < original.pixel_count(); ++i) {
    difference += std::abs(original.data()[i].r - decoded.data()[i].r) +
                  std::abs(original.data()[i].g - decoded.data()[i].g) +
                  std::abs(original.data()[i].b - decoded.data()[i].b);
  }
  EXPECT_LT(difference,
            6 * original.pixel_count());  // 2 grey levels per channel; swapped channels would be far off
}

TEST(ImageFile, FilesAreWrittenByExtension) {
  const ScratchDir folder;
  write_depth(folder.path() / "d.png", depth_image());
  EXPECT_EQ(read_depth(folder.path() / "d.png"), depth_image());
  write_colour(folder.path() / "c.png", colour_image());
  EXPECT_EQ(read_colour(folder.path() / "c.png"), colour_image());
  write_colour(folder.path() / "c.jpg", colour_image());
  EXPECT_TRUE(read_file(folder.path() / "c.jpg").starts_with("\xff\xd8"));
  EXPECT_THROW(write_colour(folder.path() / "c.bmp", colour_image()), Error);
  EXPECT_THAT(error_of([&] { write_depth(folder.path() / "none/d.png", depth_image()); }),
              HasSubstr("cannot be written"));
  EXPECT_THAT(error_of([&] { read_depth(folder.path() / "missing.png"); }),
              HasSubstr("missing.png: cannot be read"));
}

TEST(ImageFile, EveryTruncationIsAnError) {
  const auto depth = encode_png(depth_image());
  for (size_t size = 0; size < depth.size(); ++size) {
    EXPECT_THROW(decode_depth(std::span(depth).first(size), "d"), Error)
        << size << " of " << depth.size() << " bytes";
  }
  for (const auto& colour : {encode_png(colour_image()), encode_jpeg(colour_image())}) {
    for (size_t size = 0; size < colour.size(); ++size) {
      EXPECT_THROW(decode_colour(std::span(colour).first(size), "c"), Error)
          << size << " of " << colour.size() << " bytes";
    }
  }
}

TEST(ImageFile, EveryFlippedBitOfAPngIsAnError) {
  const auto intact = encode_png(depth_image(20, 16));
  for (size_t bit = 0; bit < 8 * intact.size(); ++bit) {
    auto damaged = intact;
    damaged[bit / 8] = static_cast<uint8_t>(damaged[bit / 8] ^ (1u << (bit % 8)));
    EXPECT_THROW(decode_depth(damaged, "d"), Error) << "bit " << bit;
  }
}

TEST(ImageFile, AJpegWithAHoleIsAnError) {
  auto damaged = encode_jpeg(colour_image(640, 480));
  std::fill(damaged.begin() + damaged.size() / 2, damaged.end() - 2,
            uint8_t{0});  // its end marker is still there
  EXPECT_THAT(error_of([&] { decode_colour(damaged, "c.jpg"); }), HasSubstr("c.jpg: is damaged"));
}

TEST(ImageFile, FlippedBitsOfAJpegNeverCrash) {
  const auto intact = encode_jpeg(colour_image(20, 16));
  for (size_t bit = 0; bit < 8 * intact.size(); ++bit) {
    auto damaged = intact;
    damaged[bit / 8] = static_cast<uint8_t>(damaged[bit / 8] ^ (1u << (bit % 8)));
    try {
      EXPECT_FALSE(decode_colour(damaged, "c").empty());
    } catch (const Error&) {
    }
  }
}

TEST(ImageFile, RefusesTheWrongKind) {
  EXPECT_THAT(error_of([] { decode_depth(encode_png(colour_image()), "x.png"); }),
              HasSubstr("x.png: is not a depth image"));
  EXPECT_THAT(error_of([] { decode_depth(encode_jpeg(colour_image()), "x.jpg"); }),
              HasSubstr("is not a depth image"));
  EXPECT_THAT(error_of([] { decode_colour(encode_png(depth_image()), "x.png"); }),
              HasSubstr("more than 8 bits"));
  EXPECT_THAT(error_of([] { decode_colour(as_bytes("no image at all"), "x"); }),
              HasSubstr("neither a PNG nor a JPEG"));
  EXPECT_THAT(error_of([] { decode_colour({}, "x"); }), HasSubstr("is empty"));
}

TEST(ImageFile, AbsurdSizesAreRefusedBeforeMemoryIsTaken) {
  const auto with_width = [](uint32_t width, uint32_t height) {
    auto png = encode_png(depth_image());
    for (size_t i = 0; i < 4; ++i) {
      png[16 + i] = static_cast<uint8_t>(width >> (24 - 8 * i));
      png[20 + i] = static_cast<uint8_t>(height >> (24 - 8 * i));
    }
    const auto checksum = static_cast<uint32_t>(crc32(0, png.data() + 12, 17));
    for (size_t i = 0; i < 4; ++i) png[29 + i] = static_cast<uint8_t>(checksum >> (24 - 8 * i));
    return error_of([&] { decode_depth(png, "d"); });
  };
  EXPECT_EQ(with_width(64, 48), "");
  EXPECT_THAT(with_width(1u << 30, 1u << 30), HasSubstr("claims 1073741824 x 1073741824"));
  EXPECT_THAT(with_width(0, 48), HasSubstr("claims 0 x 48"));
  EXPECT_THAT(with_width(8192, 8192), HasSubstr("truncated or damaged"));  // allowed, but not in so few bytes
}

}  // namespace
}  // namespace kt
