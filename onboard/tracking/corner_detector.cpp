// One corner per cell of each level.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/tracking/corner_detector.h"

#include <cmath>
#include <utility>

#include "shared/core/rng.h"
#include "shared/exec/for_each.h"

namespace kt {
namespace {

// Noise of the image alone stays below it.
constexpr float kMinScore = 2.0f;

// Pairs of points around the corner, nearer ones more often (as BRIEF, Calonder et al. 2010), within the
// reach of the kernel however they are turned.
std::vector<DescriptorPair> descriptor_pairs() {
  constexpr uint64_t kSeed = 20110;
  constexpr double kSigma_px = 5, kLargest_px = DetectFeature::kReach - 2;
  std::vector<DescriptorPair> pairs;
  uint64_t counter = 0;
  const auto point = [&] {
    while (true) {
      const double u = std::round(kSigma_px * random_normal(kSeed, 0, counter++)),
                   v = std::round(kSigma_px * random_normal(kSeed, 0, counter++));
      if (u * u + v * v <= kLargest_px * kLargest_px) return std::pair(u, v);
    }
  };
  while (pairs.size() < 32 * BinaryDescriptor::kWords) {
    const auto [u1, v1] = point();
    const auto [u2, v2] = point();
    if (std::hypot(u1 - u2, v1 - v2) < 3) continue;  // smoothed: too near to differ
    pairs.push_back(
        {static_cast<int8_t>(u1), static_cast<int8_t>(v1), static_cast<int8_t>(u2), static_cast<int8_t>(v2)});
  }
  return pairs;
}

int64_t cell_count(int width, int height, int side) { return int64_t{width / side} * (height / side); }

}  // namespace

CornerDetector::CornerDetector(const exec::Device& device, int width, int height, int levels, int cell_side)
    : device_(device),
      cell_side_(cell_side),
      smoothed_(device, int64_t{width} * height),
      scores_(device, int64_t{width} * height) {
  int64_t cells = 0;
  for (int level = 0; level < levels; ++level)
    cells += cell_count(width >> level, height >> level, cell_side);
  detected_ = {device, cells};
  const std::vector<DescriptorPair> pairs = descriptor_pairs();
  pairs_ = {device, static_cast<int64_t>(pairs.size())};
  pairs_.upload(pairs);
}

std::vector<Corner> CornerDetector::detect(std::span<const CornerLevel> levels) {
  std::vector<int> level_of;  // by cell
  for (size_t level = 0; level < levels.size(); ++level) {
    const IntensityView& image = levels[level].image;
    const IntensityView smoothed{smoothed_.data(), image.width, image.height};
    const int64_t cells = cell_count(image.width, image.height, cell_side_);
    exec::for_each_pixel(device_, image.width, image.height, SmoothIntensity{image, smoothed_.data()});
    exec::for_each_pixel(device_, image.width, image.height, ScoreCorner{smoothed, scores_.data()});
    exec::for_each(device_, cells,
                   DetectFeature{cell_side_, smoothed, scores_.data(), kMinScore, levels[level].surface,
                                 pairs_.data(), detected_.data() + level_of.size()});
    level_of.insert(level_of.end(), static_cast<size_t>(cells), static_cast<int>(level));
  }
  std::vector<Corner> corners;
  // Of all levels: waits once.
  const std::vector<DetectedFeature> detected = detected_.downloaded(static_cast<int64_t>(level_of.size()));
  for (size_t cell = 0; cell < detected.size(); ++cell) {
    if (detected[cell].is_found) corners.push_back({detected[cell], level_of[cell]});
  }
  return corners;
}

}  // namespace kt
