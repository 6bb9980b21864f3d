// Finds the exposure of every frame of a mission from what its frames show of the same surfaces.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "offboard/exposure/frame_gains.h"
#include "offboard/exposure/solve_gains.h"
#include "onboard/preprocess/preprocessor.h"
#include "shared/exec/device.h"
#include "shared/types/calibration.h"
#include "shared/types/rgbd_frame.h"

namespace kt {

/// Every frame is compared with the last view; where it has little left in common with it, it becomes the
/// next view. Views are compared with those before them and those that saw the same place at another time.
/// Memory: some 80 kB for each view.
class ExposureEstimator {
 public:
  /// Throws kt::Error for a calibration that makes no sense.
  ExposureEstimator(const exec::Device& device, const Calibration& calibration,
                    const PreprocessConfig& config);

  /// Takes a frame seen from T_world_camera; frames in the order of time, those without colour are left out.
  void add(const RgbdFrame& frame, const Pose& T_world_camera);

  /// The gains, by the frames' sequences. Call once, after the last frame.
  FrameGains finish();

 private:
  /// A frame and how it stands to a view.
  struct Frame {
    int64_t sequence;
    size_t view;
    ChannelValues log_ratio;  // of the frame over the view
  };

  /// Mean over the pairs.
  double disagreement_of(const std::vector<GainEdge>& pairs,
                         const std::vector<ChannelValues>& log_gains) const;

  Preprocessor preprocessor_;
  std::vector<ExposureView> views_;
  std::vector<Frame> frames_;
  int64_t since_view_ = 0;  // frames
};

}  // namespace kt
