// Finds to each depth image of a camera the colour image that was taken with it.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>

#include "onboard/source/camera_device.h"
#include "onboard/source/frame_source.h"
#include "shared/core/recycling.h"

namespace kt {

/// The partner of a depth image is the colour image nearest in time, at most half an interval of the depth
/// stream away; each is used once. A depth image without one is skipped. Nothing waits longer than it must: a
/// colour image within half an interval of its own stream has none nearer.
class FramePairing {
 public:
  explicit FramePairing(const CameraInfo& camera);

  /// Images in the order of their stamps within each stream; stamps of one clock.
  void add_depth(int64_t stamp_us, Image<uint16_t> depth);
  void add_colour(int64_t stamp_us, Image<Rgb8> colour);
  /// A colour image that cannot be used: the reason where a depth image waits for it in vain.
  void add_damaged_colour(std::string reason) { damage_ = std::move(reason); }

  /// The next depth image on which is decided: kFrame or kSkipped.
  std::optional<SourceItem> next();
  /// The same where no image comes any more.
  std::optional<SourceItem> next_at_end();

 private:
  template <typename T>
  struct Waiting {
    int64_t stamp_us;
    T image;
  };

  SourceItem paired(size_t colour);
  SourceItem unpaired();
  std::optional<size_t> nearest_colour() const;

  bool has_colour_;
  int64_t tolerance_us_, sure_us_, patience_us_;
  RecycledQueue<Waiting<Image<uint16_t>>> depth_;
  RecycledQueue<Waiting<Image<Rgb8>>> colour_;
  std::string damage_;
};

}  // namespace kt
