// A camera that is plugged in, as its driver gives it: two streams of images, not yet paired.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "shared/core/image.h"
#include "shared/types/calibration.h"

namespace kt {

/// What a camera's driver had to say.
struct CameraEvent {
  enum class Kind {
    kNothing,  ///< no image in the time given
    kDepth,
    kColour,   ///< an image
    kDamaged,  ///< an image that cannot be used; `counter` and `stamp_us` may be wrong
    kEnd,      ///< of a recording
  };
  Kind kind = Kind::kNothing;
  bool is_depth = false;    ///< which stream, of an image and of kDamaged
  int64_t stamp_us = 0;     ///< the device's clock, one for both streams, of any origin
  int64_t counter = 0;      ///< counts the images of this stream; a gap is images that the driver dropped
  Image<uint16_t> depth{};  ///< of kDepth
  Image<Rgb8> colour{};     ///< of kColour
  std::string reason{};     ///< of kDamaged
};

/// What is known of a camera once it is open.
struct CameraInfo {
  std::string name;                    ///< for people: "openni2:1d27/0609@1/5 (PS1080)"
  int64_t depth_interval_us = 33'333;  ///< between two images
  int64_t colour_interval_us = 33'333;
  bool has_colour = true;
  bool is_recording = false;  ///< it ends, waits for its reader, and its stamps are the mission's
  int64_t frame_count = -1;   ///< depth images of a recording, where it says
  std::optional<Calibration> calibration{};  ///< where the device tells
};

class CameraDevice {
 public:
  virtual ~CameraDevice() = default;
  /// Waits for the next image of either stream, at most so long. Throws kt::Error where the camera is gone.
  virtual CameraEvent read(std::chrono::milliseconds timeout) = 0;
  virtual const CameraInfo& info() const = 0;
};

/// Opens a camera, or the same one again after it was gone. Throws kt::Error where it is not there, cannot
/// do what is asked of it, or is another's at the moment.
using CameraOpener = std::function<std::unique_ptr<CameraDevice>()>;

}  // namespace kt
