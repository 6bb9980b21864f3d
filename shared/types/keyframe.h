// A frame kept for place recognition: its features, their 3-D points, its depth and a thumbnail.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "shared/core/image.h"
#include "shared/core/vec.h"
#include "shared/geometry/se3.h"
#include "shared/types/calibration.h"

namespace kt {

/// All that is needed to compare two places: keyframes of a log can be searched again without its images.
struct Keyframe {
  int64_t sequence = 0;  ///< of the frame it was made from
  int64_t timestamp_us = 0;
  int segment = 0;
  Pose T_odom_camera = Pose::Identity();
  Vector6d velocity = Vector6d::Zero();  ///< of the depth camera in its own frame, [rad/s; m/s]
  std::string descriptor_type;           ///< "surf64", "orb256", ...
  int descriptor_size = 0;               ///< bytes per descriptor
  /// Keypoints in the undistorted colour image, at full resolution; like their points, where a global shutter
  /// would have seen them at the time of the middle row of the depth image.
  std::vector<float> u_px, v_px;
  std::vector<float> scale_px;       ///< size of each keypoint's structure, in the same pixels
  std::vector<Vec3f> p_camera;       ///< their points in the depth camera (m); z = 0 where depth is missing
  std::vector<uint8_t> descriptors;  ///< keypoint count x descriptor_size bytes
  /// Of the undistorted depth camera at a quarter of its resolution (mm), as its shutter read it; 0 = none.
  Image<uint16_t> depth;
  Image<Rgb8> thumbnail;  ///< of the colour image as recorded, for people; travels as JPEG; may be empty
};

/// The camera of Keyframe::depth.
inline PinholeParams keyframe_camera(const Calibration& calibration) {
  return calibration.depth.pinhole().at_level(2);
}

}  // namespace kt
