// A pyramid of the image, and the tracker's corners of it.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/loops/corner_extractor.h"

#include "shared/exec/for_each.h"

namespace kt {
namespace {

constexpr int kCellSide = DetectFeature::kSmallestCellSide * 3 / 2;
constexpr float kFinestScale_px = 1.5f;

}  // namespace

CornerExtractor::CornerExtractor(const exec::Device& device, int width, int height)
    : device_(device), corners_(device, width, height, kLevels, kCellSide) {
  for (int level = 1; level < kLevels; ++level)
    halved_[static_cast<size_t>(level - 1)] = {device, int64_t{width >> level} * (height >> level)};
}

Keypoints CornerExtractor::extract(IntensityView image) {
  std::array<CornerLevel, kLevels> levels;
  levels[0].image = image;
  for (size_t level = 1; level < kLevels; ++level) {
    const IntensityView fine = levels[level - 1].image;
    const IntensityView view{halved_[level - 1].data(), fine.width / 2, fine.height / 2};
    exec::for_each_pixel(device_, view.width, view.height,
                         HalveIntensity{fine, view.width, halved_[level - 1].data()});
    levels[level].image = view;
  }
  Keypoints keypoints;
  for (const auto& [found, level] : corners_.detect(levels)) {
    const auto scale = static_cast<float>(1 << level);
    keypoints.u_px.push_back(scale * (found.u + 0.5f) - 0.5f);
    keypoints.v_px.push_back(scale * (found.v + 0.5f) - 0.5f);
    keypoints.scale_px.push_back(scale * kFinestScale_px);
    const auto* bytes = reinterpret_cast<const uint8_t*>(found.descriptor.bits);
    keypoints.descriptors.insert(keypoints.descriptors.end(), bytes, bytes + sizeof found.descriptor.bits);
  }
  return keypoints;
}

}  // namespace kt
