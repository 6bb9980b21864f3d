// What place recognition asks of a feature: keypoints of an image, and descriptors that can be compared.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "onboard/preprocess/intensity_kernel.h"

namespace kt {

/// How far apart two descriptors are.
enum class DescriptorMetric {
  kHamming,    ///< bits that differ
  kEuclidean,  ///< square root of the sum of squares, of signed bytes
};

struct DescriptorKind {
  std::string type;  ///< "surf64", "orb256", ...: as in the log
  int bytes = 0;     ///< of one descriptor
  DescriptorMetric metric = DescriptorMetric::kHamming;
};

struct Keypoints {
  std::vector<float> u_px, v_px;     ///< in the image; the centre of its first pixel is (0, 0)
  std::vector<float> scale_px;       ///< size of the structure: it is known to a share of that
  std::vector<uint8_t> descriptors;  ///< of one keypoint after the other
  size_t size() const { return u_px.size(); }
};

class FeatureExtractor {
 public:
  virtual ~FeatureExtractor() = default;

  virtual const DescriptorKind& kind() const = 0;

  /// Keypoints of an image that lies on the extractor's device and is no larger than the extractor was made
  /// for, in a fixed order. None lies where the image shows nothing.
  virtual Keypoints extract(IntensityView image) = 0;
};

}  // namespace kt
