// A pyramid, and the tracker's kernels on each of its levels.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/loops/corner_extractor.h"

#include <algorithm>
#include <cstring>

#include "shared/exec/for_each.h"

namespace kt {
namespace {

constexpr int kCellSide = DetectFeature::kSmallestCellSide * 3 / 2;
constexpr float kFinestScale_px = 1.5f;

int64_t cell_count(int width, int height) { return int64_t{width / kCellSide} * (height / kCellSide); }

}  // namespace

CornerExtractor::CornerExtractor(const exec::Device& device, int width, int height)
    : device_(device), smoothed_(device, int64_t{width} * height), scores_(device, int64_t{width} * height) {
  int64_t cells = 0;
  for (int level = 0; level < kLevels; ++level) {
    if (level > 0)
      levels_[static_cast<size_t>(level)] = {device, int64_t{width >> level} * (height >> level)};
    cells += cell_count(width >> level, height >> level);
  }
  detected_ = {device, cells};
  const std::vector<DescriptorPair> pairs = descriptor_pairs();
  pairs_ = {device, static_cast<int64_t>(pairs.size())};
  pairs_.upload(pairs);
}

Keypoints CornerExtractor::extract(IntensityView image) {
  int64_t at = 0;
  std::vector<int> level_of;  // by cell
  IntensityView view = image;
  for (int level = 0; level < kLevels; ++level) {
    if (level > 0) {
      float* halved = levels_[static_cast<size_t>(level)].data();
      exec::for_each_pixel(device_, view.width / 2, view.height / 2,
                           HalveIntensity{view, view.width / 2, halved});
      view = {halved, view.width / 2, view.height / 2};
    }
    const IntensityView smoothed{smoothed_.data(), view.width, view.height};
    exec::for_each_pixel(device_, view.width, view.height, SmoothIntensity{view, smoothed_.data()});
    exec::for_each_pixel(device_, view.width, view.height, ScoreCorner{smoothed, scores_.data()});
    const int64_t cells = cell_count(view.width, view.height);
    exec::for_each(device_, cells,
                   DetectFeature{kCellSide,
                                 smoothed,
                                 scores_.data(),
                                 kLeastCornerScore,
                                 {},
                                 0,
                                 pairs_.data(),
                                 detected_.data() + at});
    at += cells;
    level_of.resize(static_cast<size_t>(at), level);
  }
  Keypoints keypoints;
  const std::vector<DetectedFeature> detected = detected_.downloaded();
  for (size_t cell = 0; cell < level_of.size(); ++cell) {
    const DetectedFeature& found = detected[cell];
    if (!found.is_found) continue;
    const auto scale = static_cast<float>(1 << level_of[cell]);
    keypoints.u_px.push_back(scale * (found.u + 0.5f) - 0.5f);
    keypoints.v_px.push_back(scale * (found.v + 0.5f) - 0.5f);
    keypoints.scale_px.push_back(scale * kFinestScale_px);
    const auto* bytes = reinterpret_cast<const uint8_t*>(found.descriptor.bits);
    keypoints.descriptors.insert(keypoints.descriptors.end(), bytes, bytes + sizeof found.descriptor.bits);
  }
  return keypoints;
}

}  // namespace kt
