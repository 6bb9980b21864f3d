// Reads whichever node has an image.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/source/v4l2_camera.h"

#include <algorithm>

#include "onboard/source/camera_spec.h"
#include "onboard/source/v4l2_pixels.h"
#include "onboard/source/v4l2_stream.h"
#include "shared/core/check.h"

namespace kt {
namespace {

using std::chrono::milliseconds;

struct V4l2Nodes {
  std::string depth, colour;  ///< colour empty: a camera without
  V4l2Request depth_request, colour_request;
};

std::vector<PixelFormat> colour_formats(const std::string& asked) {
  std::vector<PixelFormat> formats = {PixelFormat::kRgb24, PixelFormat::kYuyv, PixelFormat::kMjpeg};
  if (asked.empty()) return formats;
  std::erase_if(formats, [&](PixelFormat format) { return to_string(format) != asked; });
  if (formats.empty()) throw Error("color_format=" + asked + ": it is rgb24, yuyv or mjpeg");
  return formats;
}

class V4l2Camera final : public CameraDevice {
 public:
  V4l2Camera(V4l2System& system, const V4l2Nodes& nodes)
      : system_(system), depth_(std::make_unique<V4l2Stream>(system, nodes.depth, nodes.depth_request)) {
    if (!nodes.colour.empty())
      colour_ = std::make_unique<V4l2Stream>(system, nodes.colour, nodes.colour_request);
    info_.name = "v4l2:" + nodes.depth + " (" + depth_->model() + ")";
    info_.depth_interval_us = depth_->format().interval_us;
    info_.has_colour = colour_ != nullptr;
    if (colour_) info_.colour_interval_us = colour_->format().interval_us;
  }

  CameraEvent read(milliseconds timeout) override {
    const int64_t end_us = system_.monotonic_us() + 1000 * timeout.count();
    for (int64_t left_us = 1000 * timeout.count(); left_us >= 0; left_us = end_us - system_.monotonic_us()) {
      // By turns, so that neither starves the other.
      is_depth_next_ = !is_depth_next_;
      for (const bool is_depth : {is_depth_next_, !is_depth_next_}) {
        if (!is_depth && !colour_) continue;
        V4l2Stream& stream = is_depth ? *depth_ : *colour_;
        if (const auto image = stream.read()) return event(stream, *image, is_depth);
      }
      wait_for_image(system_, *depth_, colour_.get(), milliseconds(left_us / 1000 + 1));
    }
    return {};
  }

  const CameraInfo& info() const override { return info_; }

 private:
  static CameraEvent event(const V4l2Stream& stream, const V4l2Image& image, bool is_depth) {
    CameraEvent event{.kind = is_depth ? CameraEvent::Kind::kDepth : CameraEvent::Kind::kColour,
                      .is_depth = is_depth,
                      .stamp_us = image.stamp_us,
                      .counter = image.sequence};
    try {
      if (image.is_damaged) throw Error("damaged on its way from the camera, as the driver says");
      if (is_depth) {
        event.depth = depth_image(stream.format(), image.bytes);
      } else {
        event.colour = colour_image(stream.format(), image.bytes);
      }
    } catch (const Error& error) {
      event.kind = CameraEvent::Kind::kDamaged;
      event.reason = error.what();
    }
    return event;
  }

  V4l2System& system_;
  std::unique_ptr<V4l2Stream> depth_, colour_;
  CameraInfo info_;
  bool is_depth_next_ = false;
};

}  // namespace

CameraOpener v4l2_camera(const std::string& text, V4l2System& system) {
  const CameraSpec spec =
      CameraSpec::parse("v4l2", text, {"depth", "color", "size", "color_size", "fps", "color_format"});
  V4l2Nodes nodes{.depth = spec.option("depth"),
                  .colour = spec.option("color"),
                  .depth_request = {},
                  .colour_request = {}};
  if (nodes.depth.empty() || !spec.device.empty())
    throw Error("v4l2:" + text + ": name the nodes, as in v4l2:depth=/dev/video0,color=/dev/video2; " +
                "kintsugi-collect --list-cameras shows them");
  const int rate_hz = spec.number("fps").value_or(kUsualRate_hz);
  const ImageSize size = spec.size("size").value_or(kUsualSize);
  nodes.depth_request = {{PixelFormat::kZ16}, size, rate_hz};
  nodes.colour_request = {colour_formats(spec.option("color_format")), spec.size("color_size").value_or(size),
                          rate_hz};
  return [nodes, &system] { return std::make_unique<V4l2Camera>(system, nodes); };
}

CameraOpener v4l2_camera(const std::string& text) { return v4l2_camera(text, linux_v4l2()); }

std::vector<FoundCamera> v4l2_cameras(V4l2System& system) {
  std::vector<FoundCamera> cameras;
  for (const std::string& path : system.nodes()) {
    FoundCamera found;
    found.modes = v4l2_modes(system, path, &found.name);
    if (found.modes.empty()) continue;
    const bool is_depth = found.modes.front().starts_with(to_string(PixelFormat::kZ16));
    found.spec = std::string("v4l2:") + (is_depth ? "depth=" : "color=") + path;
    cameras.push_back(std::move(found));
  }
  return cameras;
}

std::vector<FoundCamera> v4l2_cameras() { return v4l2_cameras(linux_v4l2()); }

}  // namespace kt
