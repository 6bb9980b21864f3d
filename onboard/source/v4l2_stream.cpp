// Talks to Video4Linux nodes: the one file that knows its requests.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/source/v4l2_stream.h"

#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <linux/videodev2.h>
#include <utility>

#include "shared/core/check.h"

namespace kt {
namespace {

constexpr uint32_t kBuffers = 4;
constexpr uint32_t kCapture = V4L2_BUF_TYPE_VIDEO_CAPTURE;

struct Code {
  PixelFormat format;
  uint32_t code;
  const char* name;
  int pixel_bytes;  // 0 where images have no rows
};
constexpr Code kCodes[] = {{PixelFormat::kZ16, V4L2_PIX_FMT_Z16, "z16", 2},
                           {PixelFormat::kRgb24, V4L2_PIX_FMT_RGB24, "rgb24", 3},
                           {PixelFormat::kYuyv, V4L2_PIX_FMT_YUYV, "yuyv", 2},
                           {PixelFormat::kMjpeg, V4L2_PIX_FMT_MJPEG, "mjpeg", 0}};

const Code& code_of(PixelFormat format) { return kCodes[static_cast<size_t>(format)]; }

std::string text_of(const v4l2_fract& interval) {
  const double rate =
      interval.numerator > 0 ? static_cast<double>(interval.denominator) / interval.numerator : 0;
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.4g fps", rate);
  return text.data();
}

std::string text_of(ImageSize size) { return std::to_string(size.width) + "x" + std::to_string(size.height); }

template <typename T>
std::string text_of_name(const T& bytes) {
  const char* text = reinterpret_cast<const char*>(bytes);
  return {text, strnlen(text, sizeof(bytes))};
}

bool captures(const v4l2_capability& capability) {
  const uint32_t can =
      capability.capabilities & V4L2_CAP_DEVICE_CAPS ? capability.device_caps : capability.capabilities;
  return (can & V4L2_CAP_VIDEO_CAPTURE) != 0 && (can & V4L2_CAP_STREAMING) != 0;
}

std::string remedy(int error) {
  switch (error) {
    case ENOENT:
    case ENXIO:
    case ENODEV:
      return "; is it plugged in? kintsugi-collect --list-cameras shows what is";
    case EACCES:
    case EPERM:
      return "; add the user to the group 'video' (docs/cameras.md)";
    case EBUSY:
      return "; another program uses it";
    default:
      return "";
  }
}

// The rates of one size, or "any rate" where the driver does not list them.
std::vector<std::string> rates(V4l2System& system, int fd, uint32_t code, ImageSize size) {
  std::vector<std::string> texts;
  v4l2_frmivalenum rate{};
  rate.pixel_format = code;
  rate.width = static_cast<uint32_t>(size.width);
  rate.height = static_cast<uint32_t>(size.height);
  for (; system.ioctl(fd, VIDIOC_ENUM_FRAMEINTERVALS, &rate) == 0; ++rate.index) {
    if (rate.type == V4L2_FRMIVAL_TYPE_DISCRETE) {
      texts.push_back("at " + text_of(rate.discrete));
    } else {
      texts.push_back("at " + text_of(rate.stepwise.max) + " to " + text_of(rate.stepwise.min));
      break;
    }
  }
  if (texts.empty()) texts.emplace_back("at any rate");
  return texts;
}

std::vector<std::string> modes(V4l2System& system, int fd) {
  std::vector<std::string> texts;
  for (const Code& code : kCodes) {
    v4l2_frmsizeenum size{};
    size.pixel_format = code.code;
    for (; system.ioctl(fd, VIDIOC_ENUM_FRAMESIZES, &size) == 0; ++size.index) {
      if (size.type != V4L2_FRMSIZE_TYPE_DISCRETE) {
        texts.push_back(std::string(code.name) + " " + std::to_string(size.stepwise.min_width) + "x" +
                        std::to_string(size.stepwise.min_height) + " to " +
                        std::to_string(size.stepwise.max_width) + "x" +
                        std::to_string(size.stepwise.max_height));
        break;
      }
      const ImageSize one{static_cast<int>(size.discrete.width), static_cast<int>(size.discrete.height)};
      for (const std::string& rate : rates(system, fd, code.code, one))
        texts.push_back(std::string(code.name) + " " + text_of(one) + " " + rate);
    }
  }
  return texts;
}

v4l2_buffer buffer_at(uint32_t index) {
  v4l2_buffer buffer{};
  buffer.type = kCapture;
  buffer.memory = V4L2_MEMORY_MMAP;
  buffer.index = index;
  return buffer;
}

}  // namespace

const char* to_string(PixelFormat format) { return code_of(format).name; }

V4l2Stream::V4l2Stream(V4l2System& system, std::string path, const V4l2Request& request)
    : system_(system), path_(std::move(path)), fd_(system_.open(path_)) {
  if (fd_ < 0) fail("cannot be opened");
  try {
    check_capabilities();
    bool is_agreed = false;
    for (const PixelFormat format : request.formats) is_agreed = is_agreed || try_format(format, request);
    if (!is_agreed) {
      std::string asked, offered;
      for (const PixelFormat format : request.formats)
        asked += (asked.empty() ? "" : " or ") + std::string(to_string(format));
      for (const std::string& mode : modes(system_, fd_)) offered += "\n  " + mode;
      throw Error(path_ + ": gives no " + asked + " images of " + text_of(request.size) + " at " +
                  std::to_string(request.rate_hz) + " fps; it offers" +
                  (offered.empty() ? " none of our formats" : offered));
    }
    map_buffers();
    start();
  } catch (...) {
    release();
    throw;
  }
}

V4l2Stream::~V4l2Stream() { release(); }

void V4l2Stream::fail(const std::string& what) const {
  const int error = errno;
  throw Error(path_ + ": " + what + ": " + std::strerror(error) + remedy(error));
}

void V4l2Stream::check_capabilities() {
  v4l2_capability capability{};
  if (system_.ioctl(fd_, VIDIOC_QUERYCAP, &capability) < 0) fail("is no video device");
  model_ = text_of_name(capability.card);
  if (!captures(capability))
    throw Error(path_ + ": this node of " + model_ +
                " does not capture video; kintsugi-collect --list-cameras shows those that do");
}

bool V4l2Stream::try_format(PixelFormat format, const V4l2Request& request) {
  v4l2_format wanted{};
  wanted.type = kCapture;
  v4l2_pix_format& pixels = wanted.fmt.pix;
  pixels.pixelformat = code_of(format).code;
  pixels.width = static_cast<uint32_t>(request.size.width);
  pixels.height = static_cast<uint32_t>(request.size.height);
  pixels.field = V4L2_FIELD_NONE;
  if (system_.ioctl(fd_, VIDIOC_S_FMT, &wanted) < 0) {
    if (errno == EINVAL) return false;
    fail("sets no format");
  }
  const ImageSize size{static_cast<int>(pixels.width), static_cast<int>(pixels.height)};
  if (pixels.pixelformat != code_of(format).code || size != request.size ||
      pixels.field == V4L2_FIELD_INTERLACED)
    return false;

  v4l2_streamparm rate{};
  rate.type = kCapture;
  rate.parm.capture.timeperframe = {1, static_cast<uint32_t>(request.rate_hz)};
  format_ = {format, size, static_cast<int>(pixels.bytesperline), 1'000'000 / request.rate_hz};
  const int row_bytes = code_of(format).pixel_bytes * size.width;
  if (format_.bytes_per_line < row_bytes) format_.bytes_per_line = row_bytes;  // some drivers leave it 0
  if (row_bytes == 0) format_.bytes_per_line = 0;
  if (system_.ioctl(fd_, VIDIOC_S_PARM, &rate) < 0) return true;  // one rate only: its own
  const v4l2_fract got = rate.parm.capture.timeperframe;
  if (got.numerator == 0 || got.denominator == 0) return true;
  format_.interval_us = int64_t{1'000'000} * got.numerator / got.denominator;
  return std::abs(static_cast<double>(got.denominator) / got.numerator - request.rate_hz) <
         0.02 * request.rate_hz;
}

void V4l2Stream::map_buffers() {
  v4l2_requestbuffers asked{};
  asked.count = kBuffers;
  asked.type = kCapture;
  asked.memory = V4L2_MEMORY_MMAP;
  if (system_.ioctl(fd_, VIDIOC_REQBUFS, &asked) < 0) fail("gives no buffers");
  if (asked.count < 2)
    throw Error(path_ + ": the driver has memory for " + std::to_string(asked.count) + " buffers only");
  for (uint32_t i = 0; i < asked.count; ++i) {
    v4l2_buffer buffer = buffer_at(i);
    if (system_.ioctl(fd_, VIDIOC_QUERYBUF, &buffer) < 0) fail("tells nothing of its buffers");
    void* address = system_.map(fd_, buffer.length, buffer.m.offset);
    if (address == nullptr) fail("cannot map its buffers");
    buffers_.push_back({address, buffer.length});
  }
}

void V4l2Stream::start() {
  for (uint32_t i = 0; i < buffers_.size(); ++i) queue(i);
  int type = kCapture;
  if (system_.ioctl(fd_, VIDIOC_STREAMON, &type) < 0) fail("does not start");
}

void V4l2Stream::queue(uint32_t index) {
  v4l2_buffer buffer = buffer_at(index);
  if (system_.ioctl(fd_, VIDIOC_QBUF, &buffer) < 0) fail("takes no buffer back");
}

void V4l2Stream::release() {
  int type = kCapture;
  if (!buffers_.empty()) system_.ioctl(fd_, VIDIOC_STREAMOFF, &type);  // fails where the device is gone
  for (const Mapping& mapping : buffers_) system_.unmap(mapping.address, mapping.bytes);
  buffers_.clear();
  if (fd_ >= 0) system_.close(fd_);
  fd_ = -1;
}

std::optional<V4l2Image> V4l2Stream::read() {
  if (lent_) queue(*std::exchange(lent_, std::nullopt));
  v4l2_buffer buffer = buffer_at(0);
  if (system_.ioctl(fd_, VIDIOC_DQBUF, &buffer) < 0) {
    if (errno == EAGAIN) return std::nullopt;
    fail("gives no image");
  }
  if (buffer.index >= buffers_.size()) throw Error(path_ + ": the driver names a buffer that it has not");
  lent_ = buffer.index;
  const Mapping& mapping = buffers_[buffer.index];
  const bool is_monotonic =
      (buffer.flags & V4L2_BUF_FLAG_TIMESTAMP_MASK) == V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC;
  return V4l2Image{.bytes = {static_cast<const uint8_t*>(mapping.address),
                             std::min<size_t>(buffer.bytesused, mapping.bytes)},
                   .stamp_us = is_monotonic
                                   ? int64_t{buffer.timestamp.tv_sec} * 1'000'000 + buffer.timestamp.tv_usec
                                   : system_.monotonic_us(),
                   .sequence = buffer.sequence,
                   .is_damaged = (buffer.flags & V4L2_BUF_FLAG_ERROR) != 0};
}

std::vector<std::string> v4l2_modes(V4l2System& system, const std::string& path, std::string* model) {
  const int fd = system.open(path);
  if (fd < 0) return {"cannot be opened: " + std::string(std::strerror(errno)) + remedy(errno)};
  v4l2_capability capability{};
  std::vector<std::string> texts;
  if (system.ioctl(fd, VIDIOC_QUERYCAP, &capability) == 0) {
    *model = text_of_name(capability.card);
    if (captures(capability)) texts = modes(system, fd);
  }
  system.close(fd);
  return texts;
}

void wait_for_image(V4l2System& system, const V4l2Stream& stream, const V4l2Stream* other,
                    std::chrono::milliseconds timeout) {
  const std::array<const V4l2Stream*, 2> streams = {&stream, other};
  const size_t count = other ? 2 : 1;
  std::array<pollfd, 2> files{};
  for (size_t i = 0; i < count; ++i) files[i] = {streams[i]->descriptor(), POLLIN, 0};
  if (system.poll(files.data(), count, static_cast<int>(timeout.count())) < 0)
    throw Error(stream.path() + ": waiting failed: " + std::strerror(errno));
  for (size_t i = 0; i < count; ++i) {
    if ((files[i].revents & (POLLERR | POLLHUP | POLLNVAL)) != 0)
      throw Error(streams[i]->path() + ": unplugged");
  }
}

}  // namespace kt
