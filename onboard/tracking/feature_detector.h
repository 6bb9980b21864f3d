// Corners of a frame with their points on the surface, spread over the image.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <vector>

#include "onboard/preprocess/preprocessor.h"
#include "onboard/tracking/feature_kernel.h"

namespace kt {

struct Feature {
  Eigen::Vector2d pixel;     ///< in the undistorted colour camera, at intensity level 0
  Eigen::Vector3d p_camera;  ///< its point in the depth camera (m)
  int level = 0;             ///< intensity level it was found at: it is known to 2^level pixels
  std::array<uint64_t, 4> descriptor{};
};

/// Bits in which two descriptors differ, of 256.
int descriptor_distance(const Feature& a, const Feature& b);

/// Corners that score less are noise of the image (square grey levels).
inline constexpr float kLeastCornerScore = 2.0f;

/// Pairs of points around a corner, nearer ones more often (as BRIEF, Calonder et al. 2010), within the reach
/// of DetectFeature however they are turned; one per bit of a descriptor.
std::vector<DescriptorPair> descriptor_pairs();

class FeatureDetector {
 public:
  FeatureDetector(const exec::Device& device, const Calibration& calibration);

  /// Features in a fixed order; none where the frame has no colour.
  std::vector<Feature> detect(const FrameMaps& maps);

 private:
  exec::Device device_;
  Pose T_colour_depth_;
  int cell_side_ = 0;
  exec::Buffer<float> smoothed_, scores_;
  exec::Buffer<DescriptorPair> pairs_;
  exec::Buffer<DetectedFeature> detected_;  // of all levels, finest first
};

}  // namespace kt
