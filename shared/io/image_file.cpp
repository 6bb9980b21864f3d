// Image codecs through OpenCV, and for reading JPEG libjpeg, behind the structure check of image_header.h.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/io/image_file.h"

#include <algorithm>
#include <cstring>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "shared/core/check.h"
#include "shared/io/file.h"
#include "shared/io/image_header.h"
#include "shared/io/jpeg_decoder.h"

namespace kt {
namespace {

cv::Mat decode_png(std::span<const uint8_t> bytes, const ImageHeader& header, int flags, int type,
                   const std::string& name) {
  const cv::Mat input(1, static_cast<int>(bytes.size()), CV_8U, const_cast<uint8_t*>(bytes.data()));
  cv::Mat image;
  try {
    image = cv::imdecode(input, flags);
  } catch (const cv::Exception& error) {
    throw Error(name + ": cannot be decoded: " + error.err);
  }
  if (image.empty() || image.type() != type || image.cols != header.width || image.rows != header.height) {
    throw Error(name + ": is damaged, its pixels cannot be decoded");
  }
  return image;
}

std::vector<uint8_t> encode(const char* extension, const cv::Mat& image, const std::vector<int>& options) {
  std::vector<uint8_t> bytes;
  KT_CHECK(cv::imencode(extension, image, bytes, options),
           std::string("OpenCV has no codec for ") + extension);
  return bytes;
}

/// OpenCV's view of the pixels, and its channel order.
cv::Mat bgr(const Image<Rgb8>& colour) {
  KT_CHECK(!colour.empty());
  const cv::Mat rgb(colour.height(), colour.width(), CV_8UC3, const_cast<Rgb8*>(colour.data()));
  cv::Mat result;
  cv::cvtColor(rgb, result, cv::COLOR_RGB2BGR);
  return result;
}

}  // namespace

Image<uint16_t> decode_depth(std::span<const uint8_t> bytes, const std::string& name) {
  const ImageHeader header = check_image(bytes, name);
  if (header.format != ImageHeader::Format::kPng || !header.is_grey || header.bits_per_channel != 16) {
    throw Error(name + ": is not a depth image; 16-bit greyscale PNG is needed");
  }
  const cv::Mat image = decode_png(bytes, header, cv::IMREAD_UNCHANGED, CV_16UC1, name);
  Image<uint16_t> depth(image.cols, image.rows);
  for (int v = 0; v < image.rows; ++v) std::copy_n(image.ptr<uint16_t>(v), image.cols, &depth(0, v));
  return depth;
}

Image<Rgb8> decode_colour(std::span<const uint8_t> bytes, const std::string& name) {
  const ImageHeader header = check_image(bytes, name);
  if (header.bits_per_channel > 8) {
    throw Error(name + ": has more than 8 bits per channel; a colour image is needed");
  }
  if (header.format == ImageHeader::Format::kJpeg) return decode_jpeg(bytes, header, name);
  const cv::Mat image =
      decode_png(bytes, header, cv::IMREAD_COLOR | cv::IMREAD_IGNORE_ORIENTATION, CV_8UC3, name);
  Image<Rgb8> colour(image.cols, image.rows);
  cv::Mat target(image.rows, image.cols, CV_8UC3, colour.data());
  cv::cvtColor(image, target, cv::COLOR_BGR2RGB);
  return colour;
}

Image<uint16_t> read_depth(const std::filesystem::path& path) {
  return decode_depth(as_bytes(read_file(path)), path.string());
}

Image<Rgb8> read_colour(const std::filesystem::path& path) {
  return decode_colour(as_bytes(read_file(path)), path.string());
}

std::vector<uint8_t> encode_depth_png(const Image<uint16_t>& depth) {
  KT_CHECK(!depth.empty());
  const cv::Mat image(depth.height(), depth.width(), CV_16UC1, const_cast<uint16_t*>(depth.data()));
  return encode(".png", image,
                {cv::IMWRITE_PNG_COMPRESSION, 1, cv::IMWRITE_PNG_STRATEGY, cv::IMWRITE_PNG_STRATEGY_RLE});
}

std::vector<uint8_t> encode_colour_png(const Image<Rgb8>& colour) {
  return encode(".png", bgr(colour), {cv::IMWRITE_PNG_COMPRESSION, 1});
}

std::vector<uint8_t> encode_colour_jpeg(const Image<Rgb8>& colour, int quality) {
  KT_CHECK(quality >= 1 && quality <= 100);
  return encode(".jpg", bgr(colour), {cv::IMWRITE_JPEG_QUALITY, quality});
}

void write_depth(const std::filesystem::path& path, const Image<uint16_t>& depth) {
  write_file(path, as_text(encode_depth_png(depth)));
}

void write_colour(const std::filesystem::path& path, const Image<Rgb8>& colour, int jpeg_quality) {
  const std::string extension = path.extension().string();
  if (extension == ".png") return write_file(path, as_text(encode_colour_png(colour)));
  if (extension == ".jpg" || extension == ".jpeg") {
    return write_file(path, as_text(encode_colour_jpeg(colour, jpeg_quality)));
  }
  throw Error(path.string() + ": colour images are written as .png, .jpg or .jpeg");
}

}  // namespace kt
