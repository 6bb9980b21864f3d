// A camera that OpenNI2 itself finds, opens and loses: a driver of our own, loaded by the real library.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>
#include <mutex>
#include <string>

#include "shared/types/calibration.h"
#include "shared/types/rgbd_frame.h"

namespace kt::test {

/// The one device of the driver. Images are handed out one at a time, whenever the library asks for one, so
/// that no reader is too slow. All members may be used at any time.
class SimulatedOpenNi2 {
 public:
  /// Sizes, field of view and depth unit (0.001 or 0.0001) of the images to come; before plug().
  void look_like(const Calibration& calibration) { calibration_ = calibration; }
  void offer_registration(bool offers) { offers_registration_ = offers; }
  /// Whether mirroring can be switched off; it is on.
  void offer_unmirrored(bool offers) { offers_unmirrored_ = offers; }

  /// Appears at that place; the same device as before.
  void plug(const std::string& uri);
  void unplug();

  /// Depth, then colour, with the stamps of the frame.
  void show(const RgbdFrame& frame);
  /// The depth image alone.
  void show_depth(const RgbdFrame& frame);
  /// As if so many depth images had been lost on their way.
  void drop_depth(int count);
  bool has_shown_all();

  bool is_registered() const { return is_registered_; }

  struct Image {
    RgbdFrame frame;
    bool is_depth;
    int index;
  };

  // For the driver.
  const Calibration& calibration() const { return calibration_; }
  bool offers_registration() const { return offers_registration_; }
  bool offers_unmirrored() const { return offers_unmirrored_; }
  void set_registered(bool is) { is_registered_ = is; }
  bool take(Image* image);

 private:
  std::mutex mutex_;
  Calibration calibration_;
  bool offers_registration_ = true, offers_unmirrored_ = true, is_registered_ = false;
  std::deque<Image> images_;
  int depth_index_ = 0, colour_index_ = 0;
  std::string uri_;
};

/// Of the driver that the library has loaded, or will.
SimulatedOpenNi2& simulated_openni2();

}  // namespace kt::test
