// A frame kept for place recognition: its features, their 3-D points and a thumbnail.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "shared/core/vec.h"
#include "shared/geometry/se3.h"

namespace kt {

struct Keyframe {
  int64_t sequence = 0;  ///< of the frame it was made from
  int64_t timestamp_us = 0;
  Pose T_odom_camera = Pose::Identity();
  std::string descriptor_type;       ///< "surf64", "orb", ...
  int descriptor_size = 0;           ///< bytes per descriptor
  std::vector<float> u_px, v_px;     ///< keypoints in the undistorted colour image
  std::vector<Vec3f> p_camera;       ///< their points in the depth camera (m); z = 0 where depth is missing
  std::vector<uint8_t> descriptors;  ///< keypoint count x descriptor_size bytes
  std::vector<uint8_t> thumbnail_jpeg;  ///< may be empty
};

}  // namespace kt
