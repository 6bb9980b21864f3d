// One feature per cell of each level.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/tracking/feature_detector.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "shared/core/rng.h"
#include "shared/exec/for_each.h"

namespace kt {

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

namespace {

// Pixels: so that larger images have no more features than 640 x 480, which is what the budget of a frame
// allows.
int cell_side(const PinholeParams& finest) {
  return std::max(DetectFeature::kSmallestCellSide, (finest.width + 20) / 40);
}

int64_t cell_count(const PinholeParams& camera, int side) {
  return int64_t{camera.width / side} * (camera.height / side);
}

}  // namespace

int descriptor_distance(const Feature& a, const Feature& b) {
  int distance = 0;
  for (size_t word = 0; word < a.descriptor.size(); ++word)
    distance += std::popcount(a.descriptor[word] ^ b.descriptor[word]);
  return distance;
}

FeatureDetector::FeatureDetector(const exec::Device& device, const Calibration& calibration)
    : device_(device), T_colour_depth_(calibration.T_colour_depth) {
  const PinholeParams finest = calibration.colour.pinhole().half();
  smoothed_ = {device, finest.pixel_count()};
  scores_ = {device, finest.pixel_count()};
  cell_side_ = cell_side(finest);
  int64_t cells = 0;
  PinholeParams camera = finest;
  for (int level = 0; level < kIntensityLevels; ++level, camera = camera.half())
    cells += cell_count(camera, cell_side_);
  detected_ = {device, cells};
  const std::vector<DescriptorPair> pairs = descriptor_pairs();
  pairs_ = {device, static_cast<int64_t>(pairs.size())};
  pairs_.upload(pairs);
}

std::vector<Feature> FeatureDetector::detect(const FrameMaps& maps) {
  if (!maps.has_colour) return {};
  const SurfaceLevel& surface = maps.levels[1];
  std::vector<int> levels;  // of the cells
  for (int level = 0; level < kIntensityLevels; ++level) {
    const IntensityLevel& intensity = maps.intensity.level(level);
    const PinholeParams& camera = intensity.camera;
    const IntensityView smoothed{smoothed_.data(), camera.width, camera.height};
    const int64_t cells = cell_count(camera, cell_side_);
    exec::for_each_pixel(device_, camera.width, camera.height,
                         SmoothIntensity{intensity.view(), smoothed_.data()});
    exec::for_each_pixel(device_, camera.width, camera.height, ScoreCorner{smoothed, scores_.data()});
    exec::for_each(device_, cells,
                   DetectFeature{cell_side_,
                                 smoothed,
                                 scores_.data(),
                                 kLeastCornerScore,
                                 {camera, surface.depth_view(), surface.camera, to_rigid3f(T_colour_depth_),
                                  to_rigid3f(T_colour_depth_.inverse())},
                                 1,
                                 pairs_.data(),
                                 detected_.data() + levels.size()});
    levels.insert(levels.end(), static_cast<size_t>(cells), level);
  }
  std::vector<Feature> features;
  const std::vector<DetectedFeature> detected = detected_.downloaded();  // of all levels: waits once
  for (size_t cell = 0; cell < detected.size(); ++cell) {
    const DetectedFeature& found = detected[cell];
    if (!found.is_found) continue;
    const double scale = 1 << levels[cell];
    Feature feature;
    feature.pixel = {scale * (static_cast<double>(found.u) + 0.5) - 0.5,
                     scale * (static_cast<double>(found.v) + 0.5) - 0.5};
    feature.p_camera = {found.p_camera.x, found.p_camera.y, found.p_camera.z};
    feature.level = levels[cell];
    for (size_t word = 0; word < feature.descriptor.size(); ++word) {
      feature.descriptor[word] =
          found.descriptor.bits[2 * word] | static_cast<uint64_t>(found.descriptor.bits[2 * word + 1]) << 32;
    }
    features.push_back(feature);
  }
  return features;
}

}  // namespace kt
