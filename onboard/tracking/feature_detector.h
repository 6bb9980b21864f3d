// Corners of a frame with their points on the surface, spread over the image.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <vector>

#include "onboard/preprocess/frame_motion.h"
#include "onboard/preprocess/preprocessor.h"
#include "onboard/tracking/corner_detector.h"

namespace kt {

struct Feature {
  Eigen::Vector2d pixel;     ///< in the undistorted colour camera, at intensity level 0
  Eigen::Vector3d p_camera;  ///< its point in the depth camera (m)
  int level = 0;             ///< intensity level it was found at: it is known to 2^level pixels
  std::array<uint64_t, 4> descriptor{};
};

/// Bits in which two descriptors differ, of 256.
int descriptor_distance(const Feature& a, const Feature& b);

class FeatureDetector {
 public:
  FeatureDetector(const exec::Device& device, const Calibration& calibration);

  /// Features in a fixed order, as a global shutter would have seen them (SettledPoints); none where the
  /// frame has no colour.
  std::vector<Feature> detect(const FrameMaps& maps, const FrameMotion& motion = {});

 private:
  Pose T_colour_depth_;
  CornerDetector corners_;
};

}  // namespace kt
