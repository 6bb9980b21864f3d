// How far the camera has turned since the last good frame, from the images alone: a guess that holds through
// fast turns.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "onboard/preprocess/preprocessor.h"
#include "onboard/tracking/photometric_kernel.h"

namespace kt {

class RotationAligner {
 public:
  RotationAligner(const exec::Device& device, const Calibration& calibration);

  /// Keeps the image that later frames are aligned with.
  void remember(const FrameMaps& maps);

  /// Rotation R_last_current of the depth camera, found from `R_guess` by direct alignment of the smallest
  /// images (SO(3) pre-alignment, Lovegrove and Davison 2010); the guess where that does not fit better, or
  /// one of the frames has no colour.
  Eigen::Matrix3d align(const FrameMaps& maps, const Eigen::Matrix3d& R_guess);

 private:
  exec::Device device_;
  Eigen::Matrix3d R_colour_depth_;
  exec::Buffer<float> last_;
  bool has_last_ = false;
  int64_t last_us_ = 0, last_colour_us_ = 0;
  exec::ReductionWorkspace workspace_;
};

}  // namespace kt
