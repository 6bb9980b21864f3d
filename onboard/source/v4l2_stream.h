// One Video4Linux node: its formats, and its images as they come in mapped memory.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "onboard/source/camera_spec.h"
#include "onboard/source/v4l2_system.h"

namespace kt {

enum class PixelFormat { kZ16, kRgb24, kYuyv, kMjpeg };
/// "z16", "rgb24", "yuyv" or "mjpeg".
const char* to_string(PixelFormat format);

/// What is asked of a node: the first of `formats` that it has in this size at this rate.
struct V4l2Request {
  std::vector<PixelFormat> formats;
  ImageSize size;
  int rate_hz = 30;
};

/// What it agreed to.
struct V4l2Format {
  PixelFormat format = PixelFormat::kZ16;
  ImageSize size;
  int bytes_per_line = 0;  ///< 0 of kMjpeg
  int64_t interval_us = 0;
};

/// An image in the driver's memory, until the next call of read.
struct V4l2Image {
  std::span<const uint8_t> bytes;
  int64_t stamp_us =
      0;  ///< CLOCK_MONOTONIC: when the driver says, or when it was read where the driver has another clock
  int64_t sequence = 0;  ///< counts the images that the sensor gave; gaps were dropped
  bool is_damaged = false;
};

/// A node that streams. Every member function throws kt::Error naming node and remedy where the node is gone
/// or refuses.
class V4l2Stream {
 public:
  /// Opens the node, agrees on a format and starts it.
  V4l2Stream(V4l2System& system, std::string path, const V4l2Request& request);
  ~V4l2Stream();
  V4l2Stream(const V4l2Stream&) = delete;
  V4l2Stream& operator=(const V4l2Stream&) = delete;

  const std::string& path() const { return path_; }
  const V4l2Format& format() const { return format_; }
  const std::string& model() const { return model_; }
  int descriptor() const { return fd_; }

  /// The oldest image that waits; none where none does.
  std::optional<V4l2Image> read();

 private:
  struct Mapping {
    void* address;
    size_t bytes;
  };

  void check_capabilities();
  bool try_format(PixelFormat format, const V4l2Request& request);
  void map_buffers();
  void start();
  void queue(uint32_t index);
  void release();
  [[noreturn]] void fail(const std::string& what) const;

  V4l2System& system_;
  std::string path_, model_;
  int fd_ = -1;
  V4l2Format format_;
  std::vector<Mapping> buffers_;
  std::optional<uint32_t> lent_;  ///< the buffer of the image handed out last
};

/// What a node can do, for people: "z16 640x480 at 30 fps", a line each; empty where it captures none of our
/// formats. `model` is what the device calls itself.
std::vector<std::string> v4l2_modes(V4l2System& system, const std::string& path, std::string* model);

/// Waits until one of the streams has an image, or the time is over; throws kt::Error where one is gone.
/// `other` may be null.
void wait_for_image(V4l2System& system, const V4l2Stream& stream, const V4l2Stream* other,
                    std::chrono::milliseconds timeout);

}  // namespace kt
