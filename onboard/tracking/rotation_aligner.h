// How far the camera has turned since the last good frame, from the images: a guess that holds through fast
// turns.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "onboard/preprocess/preprocessor.h"
#include "onboard/tracking/photometric_kernel.h"

namespace kt {

class RotationAligner {
 public:
  RotationAligner(const exec::Device& device, const Calibration& calibration);

  /// Keeps the image that later frames are aligned with, and its depth.
  void remember(const FrameMaps& maps);

  /// Pose T_last_current of the depth camera: `T_guess` turned about its own place, found by direct alignment
  /// of the smallest images (SO(3) pre-alignment, Lovegrove and Davison 2010). Each pixel moves as its depth
  /// says that it does by the guess's translation: otherwise a step to the side before a wall looks like a
  /// turn. The guess where that does not fit better, or one of the frames has no colour.
  Pose align(const FrameMaps& maps, const Pose& T_guess);

 private:
  exec::Device device_;
  Pose T_colour_depth_;
  PinholeParams depth_camera_;  // of the coarsest level
  int64_t visible_points_;      // at most, of a scene far away
  exec::Buffer<Vec4f> last_;    // as of SamplePhotometricPoint
  bool has_last_ = false;
  int64_t last_us_ = 0, last_colour_us_ = 0;
  exec::ReductionWorkspace workspace_;
};

}  // namespace kt
