// Corners of an image pyramid, spread over it, with their descriptors.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include "onboard/tracking/feature_kernel.h"
#include "shared/exec/buffer.h"

namespace kt {

/// One level of a pyramid, on the device. Where `surface` has a depth image, only corners with a point on it
/// count.
struct CornerLevel {
  IntensityView image;
  SurfaceBehind surface;
};

struct Corner {
  DetectedFeature feature;  ///< its pixel is one of its level
  int level = 0;
};

class CornerDetector {
 public:
  /// For pyramids of `levels` levels whose finest image has at most width x height pixels; at most one corner
  /// per cell of cell_side x cell_side pixels of a level.
  CornerDetector(const exec::Device& device, int width, int height, int levels, int cell_side);

  /// From the finest level on, by cell.
  std::vector<Corner> detect(std::span<const CornerLevel> levels);

 private:
  exec::Device device_;
  int cell_side_;
  exec::Buffer<float> smoothed_, scores_;
  exec::Buffer<DescriptorPair> pairs_;
  exec::Buffer<DetectedFeature> detected_;  // of all levels, finest first
};

}  // namespace kt
