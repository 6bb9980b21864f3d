// Answers the requests as the kernel's documentation says a driver does.
// SPDX-License-Identifier: BSD-3-Clause
#include "tests/onboard/source/simulated_v4l2.h"

#include <algorithm>
#include <cerrno>
#include <linux/videodev2.h>

namespace kt::test {

const uint32_t kSimulatedZ16 = V4L2_PIX_FMT_Z16, kSimulatedRgb24 = V4L2_PIX_FMT_RGB24;

namespace {

int failed(int error) {
  errno = error;
  return -1;
}

int pixel_bytes(uint32_t code) { return code == V4L2_PIX_FMT_RGB24 ? 3 : code == V4L2_PIX_FMT_MJPEG ? 0 : 2; }

int query(const SimulatedNode& node, v4l2_capability* capability) {
  node.card.copy(reinterpret_cast<char*>(capability->card), sizeof(capability->card) - 1);
  capability->capabilities = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING | V4L2_CAP_DEVICE_CAPS;
  capability->device_caps =
      node.captures ? V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING : V4L2_CAP_META_CAPTURE;
  return 0;
}

// A driver takes the nearest it has.
int set_format(SimulatedNode& node, v4l2_format* format) {
  if (node.formats.empty()) return failed(EINVAL);
  v4l2_pix_format& pixels = format->fmt.pix;
  const auto distance = [&](const SimulatedFormat& own) {
    return std::abs(own.width - static_cast<int>(pixels.width)) + 100'000 * (own.code != pixels.pixelformat);
  };
  const auto nearest =
      std::min_element(node.formats.begin(), node.formats.end(),
                       [&](const auto& a, const auto& b) { return distance(a) < distance(b); });
  node.format = &*nearest;
  pixels.pixelformat = nearest->code;
  pixels.width = static_cast<uint32_t>(nearest->width);
  pixels.height = static_cast<uint32_t>(nearest->height);
  pixels.bytesperline = static_cast<uint32_t>(nearest->width * pixel_bytes(nearest->code) + nearest->padding);
  pixels.sizeimage = static_cast<uint32_t>(nearest->height) * std::max(pixels.bytesperline, 4 * pixels.width);
  return 0;
}

int set_rate(SimulatedNode& node, v4l2_streamparm* parameters) {
  v4l2_fract& interval = parameters->parm.capture.timeperframe;
  const int asked = static_cast<int>(interval.denominator / interval.numerator);
  const auto& rates = node.format->rates_hz;
  node.rate_hz = *std::min_element(rates.begin(), rates.end(),
                                   [&](int a, int b) { return std::abs(a - asked) < std::abs(b - asked); });
  interval = {1, static_cast<uint32_t>(node.rate_hz)};
  return 0;
}

int list_size(const SimulatedNode& node, v4l2_frmsizeenum* size) {
  std::vector<const SimulatedFormat*> own;
  for (const SimulatedFormat& format : node.formats) {
    if (format.code == size->pixel_format) own.push_back(&format);
  }
  if (size->index >= own.size()) return failed(EINVAL);
  size->type = V4L2_FRMSIZE_TYPE_DISCRETE;
  size->discrete = {static_cast<uint32_t>(own[size->index]->width),
                    static_cast<uint32_t>(own[size->index]->height)};
  return 0;
}

int list_rate(const SimulatedNode& node, v4l2_frmivalenum* rate) {
  for (const SimulatedFormat& format : node.formats) {
    if (format.code != rate->pixel_format || format.width != static_cast<int>(rate->width)) continue;
    if (rate->index >= format.rates_hz.size()) return failed(EINVAL);
    rate->type = V4L2_FRMIVAL_TYPE_DISCRETE;
    rate->discrete = {1, static_cast<uint32_t>(format.rates_hz[rate->index])};
    return 0;
  }
  return failed(EINVAL);
}

int make_buffers(SimulatedNode& node, v4l2_requestbuffers* asked) {
  const auto bytes = static_cast<size_t>(node.format->height) *
                     static_cast<size_t>(4 * node.format->width + node.format->padding);
  node.buffers.clear();
  for (uint32_t i = 0; i < asked->count; ++i)
    node.buffers.push_back(std::make_unique<std::vector<uint8_t>>(bytes));
  return 0;
}

int describe_buffer(const SimulatedNode& node, v4l2_buffer* buffer) {
  if (buffer->index >= node.buffers.size()) return failed(EINVAL);
  buffer->length = static_cast<uint32_t>(node.buffers[buffer->index]->size());
  buffer->m.offset = buffer->index * 4096;
  return 0;
}

int take_image(SimulatedNode& node, v4l2_buffer* buffer) {
  if (!node.is_streaming) return failed(EINVAL);
  if (node.images.empty() || node.queued.empty()) return failed(EAGAIN);
  const SimulatedImage image = std::move(node.images.front());
  node.images.pop_front();
  buffer->index = node.queued.front();
  node.queued.pop_front();
  std::vector<uint8_t>& memory = *node.buffers[buffer->index];
  std::copy_n(image.bytes.begin(), std::min(image.bytes.size(), memory.size()), memory.begin());
  buffer->bytesused = static_cast<uint32_t>(image.bytes.size());
  buffer->sequence = image.sequence;
  buffer->timestamp = {image.stamp_us / 1'000'000, image.stamp_us % 1'000'000};
  buffer->flags = (node.is_monotonic ? V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC : V4L2_BUF_FLAG_TIMESTAMP_UNKNOWN) |
                  (image.is_damaged ? V4L2_BUF_FLAG_ERROR : 0);
  return 0;
}

}  // namespace

void SimulatedV4l2::unplug() {
  for (auto& [path, node] : nodes_) node.is_unplugged = true, node.images.clear();
}

void SimulatedV4l2::plug() {
  for (auto& [path, node] : nodes_) node.is_unplugged = false;
}

bool SimulatedV4l2::is_all_released() const {
  return open_.empty() && std::all_of(nodes_.begin(), nodes_.end(),
                                      [](const auto& entry) { return entry.second.mapped == 0; });
}

int SimulatedV4l2::open(const std::string& path) {
  const auto found = nodes_.find(path);
  if (found == nodes_.end() || found->second.is_unplugged) return failed(ENOENT);
  if (found->second.open_error != 0) return failed(found->second.open_error);
  found->second.is_open = true;
  open_[next_fd_] = path;
  return next_fd_++;
}

int SimulatedV4l2::close(int fd) {
  if (SimulatedNode* node = open_node(fd)) node->is_open = node->is_streaming = false, node->queued.clear();
  return open_.erase(fd) == 1 ? 0 : failed(EBADF);
}

SimulatedNode* SimulatedV4l2::open_node(int fd) {
  const auto found = open_.find(fd);
  return found == open_.end() ? nullptr : &nodes_[found->second];
}

int SimulatedV4l2::ioctl(int fd, unsigned long request, void* argument) {
  SimulatedNode* node = open_node(fd);
  if (node == nullptr) return failed(EBADF);
  if (node->is_unplugged) return failed(ENODEV);
  switch (request) {
    case VIDIOC_QUERYCAP:
      return query(*node, static_cast<v4l2_capability*>(argument));
    case VIDIOC_S_FMT:
      return set_format(*node, static_cast<v4l2_format*>(argument));
    case VIDIOC_S_PARM:
      return set_rate(*node, static_cast<v4l2_streamparm*>(argument));
    case VIDIOC_ENUM_FRAMESIZES:
      return list_size(*node, static_cast<v4l2_frmsizeenum*>(argument));
    case VIDIOC_ENUM_FRAMEINTERVALS:
      return list_rate(*node, static_cast<v4l2_frmivalenum*>(argument));
    case VIDIOC_REQBUFS:
      return make_buffers(*node, static_cast<v4l2_requestbuffers*>(argument));
    case VIDIOC_QUERYBUF:
      return describe_buffer(*node, static_cast<v4l2_buffer*>(argument));
    case VIDIOC_QBUF:
      node->queued.push_back(static_cast<v4l2_buffer*>(argument)->index);
      return 0;
    case VIDIOC_DQBUF:
      return take_image(*node, static_cast<v4l2_buffer*>(argument));
    case VIDIOC_STREAMON:
      node->is_streaming = true;
      return 0;
    case VIDIOC_STREAMOFF:
      node->is_streaming = false;
      return 0;
    default:
      return failed(ENOTTY);
  }
}

void* SimulatedV4l2::map(int fd, size_t, int64_t offset) {
  SimulatedNode* node = open_node(fd);
  if (node == nullptr) return nullptr;
  ++node->mapped;
  return node->buffers.at(static_cast<size_t>(offset / 4096))->data();
}

void SimulatedV4l2::unmap(void* address, size_t) {
  for (auto& [path, node] : nodes_) {
    for (const auto& buffer : node.buffers) node.mapped -= buffer->data() == address;
  }
}

int SimulatedV4l2::poll(pollfd* files, size_t count, int timeout_ms) {
  int ready = 0;
  for (size_t i = 0; i < count; ++i) {
    const SimulatedNode* node = open_node(files[i].fd);
    files[i].revents = static_cast<short>(node == nullptr         ? POLLNVAL
                                          : node->is_unplugged    ? POLLERR | POLLHUP
                                          : !node->images.empty() ? POLLIN
                                                                  : 0);
    ready += files[i].revents != 0;
  }
  if (ready == 0 && on_silence) on_silence();
  if (ready == 0) now_us += int64_t{1000} * timeout_ms;
  return ready;
}

std::vector<std::string> SimulatedV4l2::nodes() {
  std::vector<std::string> paths;
  for (const auto& [path, node] : nodes_) {
    if (!node.is_unplugged) paths.push_back(path);
  }
  return paths;
}

}  // namespace kt::test
