// Frames of a camera: pairs its images, counts those that were lost, and waits for it where it is gone.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "onboard/source/camera_device.h"
#include "onboard/source/frame_pairing.h"
#include "onboard/source/frame_source.h"
#include "onboard/source/stamp_clock.h"
#include "shared/core/recycling.h"

namespace kt {

/// The clocks that a live camera needs; tests have their own.
struct CameraClock {
  std::function<int64_t()> wall_us;    ///< since 1970; may be set at any time
  std::function<int64_t()> steady_us;  ///< only goes forward
  std::function<void(std::chrono::milliseconds)> wait;

  static CameraClock of_system();
};

/// A live camera that is unplugged, or gives no image for 2 s, is closed and opened again, after 0.5 s first
/// and after twice as long each time, 8 s at most. Meanwhile next() says kInterrupted, at once and then every
/// second. It never takes much longer than 0.2 s. The mission's stamps are those of StampClock. A recording
/// has stamps of its own, and an end.
class CameraSource final : public FrameSource {
 public:
  /// Opens the camera. Throws kt::Error where it cannot be opened this first time.
  explicit CameraSource(CameraOpener open, CameraClock clock = CameraClock::of_system());

  SourceItem next() override;
  bool is_live() const override { return !info_.is_recording; }
  int64_t frame_count() const override { return info_.frame_count; }
  /// Throws kt::Error where the device does not tell its lenses.
  const Calibration& calibration() const override;

 private:
  void read();
  void take(CameraEvent event);
  void count_dropped(const CameraEvent& event);
  /// Of a recording; `why` it ended early, or empty.
  void end(const std::string& why);
  void lose(const std::string& reason);
  void try_again();
  void skip(int64_t count, const std::string& reason);

  CameraOpener open_;
  CameraClock clock_;
  std::unique_ptr<CameraDevice> camera_;  ///< null while it is gone
  CameraInfo info_;                       ///< of the camera as it was opened first
  FramePairing pairing_;
  StampClock stamps_;
  std::optional<int64_t> last_counter_;  ///< of the depth stream
  int64_t depth_images_ = 0;             ///< read and dropped
  RecycledQueue<SourceItem> ready_;
  std::chrono::milliseconds silence_{0};  ///< since the last image
  bool is_at_end_ = false;
  std::chrono::milliseconds patience_{0}, until_next_try_{0}, until_report_{0};  ///< while it is gone
  std::string gone_because_;
};

}  // namespace kt
