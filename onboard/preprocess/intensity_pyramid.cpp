// The order of the intensity kernels.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/preprocess/intensity_pyramid.h"

#include <vector>

#include "shared/exec/for_each.h"

namespace kt {
namespace {

// Full-resolution pixel u of the centre of pixel u at half resolution, and back.
double to_full(double half) { return 2 * half + 0.5; }
double to_half(double full) { return (full - 0.5) / 2; }

std::vector<LensPosition> lens_positions(const Camera& camera, int width, int height) {
  std::vector<LensPosition> positions;
  positions.reserve(static_cast<size_t>(width) * static_cast<size_t>(height));
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      const Eigen::Vector2d recorded =
          camera.project({(to_full(u) - camera.cx) / camera.fx, (to_full(v) - camera.cy) / camera.fy, 1.0});
      positions.push_back(
          {static_cast<float>(to_half(recorded.x())), static_cast<float>(to_half(recorded.y()))});
    }
  }
  return positions;
}

}  // namespace

IntensityPyramid::IntensityPyramid(const exec::Device& device, const Camera& camera)
    : device_(device), camera_(camera) {
  PinholeParams level_camera = camera.pinhole();
  for (IntensityLevel& level : levels_) {
    level_camera = level_camera.half();
    level.camera = level_camera;
    level.levels = {device, level_camera.pixel_count()};
  }
  if (!camera.is_distorted()) return;
  const PinholeParams& half = levels_[0].camera;
  recorded_ = {device, half.pixel_count()};
  lens_positions_ = {device, half.pixel_count()};
  lens_positions_.upload(lens_positions(camera, half.width, half.height));
}

void IntensityPyramid::build(const Rgb8* colour) {
  IntensityLevel& half = levels_[0];
  const int width = half.camera.width, height = half.camera.height;
  const bool distorted = lens_positions_.size() > 0;
  exec::for_each_pixel(
      device_, width, height,
      HalveToIntensity{colour, camera_.width, width, distorted ? recorded_.data() : half.levels.data()});
  if (distorted) {
    exec::for_each_pixel(
        device_, width, height,
        UndistortIntensity{{recorded_.data(), width, height}, lens_positions_.data(), half.levels.data()});
  }
  for (int l = 1; l < kIntensityLevels; ++l) {
    IntensityLevel& coarse = levels_[static_cast<size_t>(l)];
    exec::for_each_pixel(device_, coarse.camera.width, coarse.camera.height,
                         HalveIntensity{level(l - 1).view(), coarse.camera.width, coarse.levels.data()});
  }
}

}  // namespace kt
