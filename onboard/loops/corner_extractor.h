// The tracker's corners as features of places.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>

#include "onboard/loops/feature_extractor.h"
#include "onboard/tracking/corner_detector.h"

namespace kt {

/// Corners (Shi and Tomasi 1994), the best of each cell of three pyramid levels, with turned binary
/// descriptors (ORB, Rublee et al. 2011).
class CornerExtractor final : public FeatureExtractor {
 public:
  /// For images of up to width x height pixels.
  CornerExtractor(const exec::Device& device, int width, int height);

  const DescriptorKind& kind() const override { return kind_; }
  Keypoints extract(IntensityView image) override;

 private:
  static constexpr int kLevels = 3;
  exec::Device device_;
  DescriptorKind kind_{"orb256", 32, DescriptorMetric::kHamming};
  std::array<exec::Buffer<float>, kLevels - 1> halved_;  // the image's coarser levels
  CornerDetector corners_;
};

}  // namespace kt
