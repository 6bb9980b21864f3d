// The collector's input from LCM within one process, for fuzzed messages to come over.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <optional>
#include <span>

#include "onboard/source/bare_sources.h"
#include "onboard/source/checked_source.h"
#include "shared/wire/lcm_bus.h"
#include "tests/fuzz/checks.h"
#include "tests/fuzz/small_frame.h"

namespace kt {

class LiveInput {
 public:
  /// Publishes a message and takes all that comes of it; what comes must be usable.
  void publish(std::string_view channel, std::span<const uint8_t> message) {
    bus_->publish(channel, message);
    for (SourceItem item = source_.next(); item.kind != SourceItem::Kind::kNothingYet;
         item = source_.next()) {
      require(item.kind != SourceItem::Kind::kEnd, "a message ended the input");
      if (item.kind == SourceItem::Kind::kFrame) check(item.frame);
      if (item.kind == SourceItem::Kind::kMotion) check(item.motion);
    }
  }
  int64_t frames() const { return frames_; }

 private:
  static Calibration calibration() {
    Calibration calibration;
    calibration.depth = {.width = 16, .height = 16, .fx = 20, .fy = 20, .cx = 7.5, .cy = 7.5};
    calibration.colour = calibration.depth;
    calibration.T_body_camera.translation() = Eigen::Vector3d(0.3, -0.2, 0.5);
    return calibration;
  }
  // The mission goes on with it as one of the camera, and records that.
  void check(const MotionSample& sample) const {
    require(ranges::hold(sample), "a sample out of range");
    require(ranges::hold(of_camera(sample, source_.calibration().T_body_camera)),
            "a sample out of range, as one of the camera");
  }
  void check(const RgbdFrame& frame) {
    require(frame.sequence == frames_++, "frames are not numbered without gaps");
    require(frame.depth.width() == 16 && frame.depth.height() == 16, "a depth image of the wrong size");
    require(frame.colour.empty() || (frame.colour.width() == 16 && frame.colour.height() == 16),
            "a colour image of the wrong size");
    require(ranges::is_stamp(frame.timestamp_us) && (!last_us_ || frame.timestamp_us > *last_us_),
            "stamps do not increase");
    last_us_ = frame.timestamp_us;
  }

  std::shared_ptr<LcmBus> bus_ = std::make_shared<LcmBus>("memq://");
  CheckedSource source_{open_lcm_source(bus_, "fuzz", std::chrono::milliseconds(0)), calibration()};
  int64_t frames_ = 0;
  std::optional<int64_t> last_us_;
};

}  // namespace kt
