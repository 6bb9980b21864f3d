// SURF: blobs of an image and 64 numbers for each that stay the same where the image is turned and scaled.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>

#include "onboard/loops/feature_extractor.h"
#include "onboard/loops/surf_kernel.h"
#include "shared/exec/buffer.h"

namespace kt {

struct SurfConfig {
  int octaves = 3;          ///< 1 to 4: filters up to 27, 51, 99 and 195 pixels
  double min_response = 8;  ///< square grey levels: weaker blobs are dropped
  int max_keypoints = 500;  ///< the strongest are kept
  bool upright = false;     ///< keypoints get no direction: for cameras that do not roll, faster
};

class SurfExtractor final : public FeatureExtractor {
 public:
  /// Allocates for images of up to width x height. Throws kt::Error for a configuration out of range.
  SurfExtractor(const exec::Device& device, int width, int height, const SurfConfig& config);

  const DescriptorKind& kind() const override { return kind_; }

  /// Ordered by octave, row and column. The scale is the paper's: some 3/4 of the sigma
  /// of a round blob. All that a descriptor looks at, up to
  /// 15 times the scale from the keypoint, is shown by the image.
  Keypoints extract(IntensityView image) override;

 private:
  static constexpr int kSpare = 2;  // as many times max_keypoints get a direction

  IntegralImage integrate(const IntensityView& image);
  /// Fills as many of `octaves` as fit the image, and their flags; returns how many.
  int rate_octaves(const IntegralImage& image, HessianOctave* octaves);
  std::vector<SurfPoint> find_points(const IntegralImage& image);
  Keypoints describe(const IntegralImage& image, const std::vector<SurfPoint>& points);

  exec::Device device_;
  int width_, height_;
  SurfConfig config_;
  DescriptorKind kind_{"surf64", QuantiseDescriptor::kSize, DescriptorMetric::kEuclidean};
  exec::Buffer<uint32_t> levels_, hidden_;  // of the integral image
  std::array<std::array<exec::Buffer<float>, HessianOctave::kLayers>, RefinePeak::kMaxOctaves> layers_;
  exec::Buffer<uint8_t> flags_;  // of all octaves
  exec::Buffer<int32_t> peaks_;  // those set
  exec::Buffer<SurfPoint> points_, chosen_, oriented_;
  exec::Buffer<DirectionSample> direction_samples_;
  exec::Buffer<OrientPoint::Windows> windows_;
  exec::Buffer<float> weights_, descriptor_sums_;
  exec::Buffer<uint8_t> descriptors_;
};

}  // namespace kt
