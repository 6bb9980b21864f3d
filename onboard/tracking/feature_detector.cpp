// The corners of a frame's intensity pyramid as features.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/tracking/feature_detector.h"

#include <algorithm>
#include <bit>

namespace kt {
namespace {

// Pixels: so that larger images have no more features than 640 x 480, which is what the budget of a frame
// allows.
int cell_side(const PinholeParams& finest) {
  return std::max(DetectFeature::kSmallestCellSide, (finest.width + 20) / 40);
}

CornerDetector corner_detector(const exec::Device& device, const PinholeParams& finest) {
  return {device, finest.width, finest.height, kIntensityLevels, cell_side(finest)};
}

}  // namespace

int descriptor_distance(const Feature& a, const Feature& b) {
  int distance = 0;
  for (size_t word = 0; word < a.descriptor.size(); ++word)
    distance += std::popcount(a.descriptor[word] ^ b.descriptor[word]);
  return distance;
}

FeatureDetector::FeatureDetector(const exec::Device& device, const Calibration& calibration)
    : T_colour_depth_(calibration.T_colour_depth),
      corners_(corner_detector(device, calibration.colour.pinhole().half())) {}

std::vector<Feature> FeatureDetector::detect(const FrameMaps& maps, const FrameMotion& motion) {
  if (!maps.has_colour) return {};
  const SurfaceLevel& surface = maps.levels[1];
  const Pose T_colour_depth = T_colour_depth_ * motion.T_depth_colour_time().inverse();
  std::array<CornerLevel, kIntensityLevels> levels;
  for (int level = 0; level < kIntensityLevels; ++level) {
    const IntensityLevel& intensity = maps.intensity.level(level);
    levels[static_cast<size_t>(level)] = {
        intensity.view(),
        {intensity.camera, surface.depth_view(), surface.camera, to_rigid3f(T_colour_depth),
         to_rigid3f(T_colour_depth.inverse()), motion.colour_rows(intensity.camera, T_colour_depth_),
         motion.depth_rows(surface.camera)}};
  }
  const Rigid3f T_colour = to_rigid3f(T_colour_depth_);
  const PinholeParams& finest = maps.intensity.level(0).camera;
  std::vector<Feature> features;
  for (const auto& [found, level] : corners_.detect(levels)) {
    const double scale = 1 << level;
    Feature feature;
    feature.pixel = {scale * (static_cast<double>(found.u) + 0.5) - 0.5,
                     scale * (static_cast<double>(found.v) + 0.5) - 0.5};
    feature.p_camera = {found.p_camera.x, found.p_camera.y, found.p_camera.z};
    if (!motion.is_still()) {
      const Vec3f c = T_colour * found.p_camera;
      feature.pixel = {finest.project_u(c), finest.project_v(c)};
    }
    feature.level = level;
    for (size_t word = 0; word < feature.descriptor.size(); ++word) {
      feature.descriptor[word] =
          found.descriptor.bits[2 * word] | static_cast<uint64_t>(found.descriptor.bits[2 * word + 1]) << 32;
    }
    features.push_back(feature);
  }
  return features;
}

}  // namespace kt
