// The intensity images of a frame, at half, a quarter and an eighth of the colour image's resolution.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>

#include "onboard/preprocess/intensity_kernel.h"
#include "shared/exec/buffer.h"
#include "shared/geometry/camera.h"

namespace kt {

/// 0 = half, 1 = a quarter, 2 = an eighth of the resolution.
inline constexpr int kIntensityLevels = 3;

/// One level, in the undistorted colour camera of that level.
struct IntensityLevel {
  PinholeParams camera;
  exec::Buffer<float> levels;
  IntensityView view() const { return {levels.data(), camera.width, camera.height}; }
};

/// Owns the pyramid and makes it; lives on the device.
class IntensityPyramid {
 public:
  IntensityPyramid() = default;
  IntensityPyramid(const exec::Device& device, const Camera& camera);

  /// From the colour image as recorded, on the device.
  void build(const Rgb8* colour);

  const IntensityLevel& level(int level) const { return levels_[static_cast<size_t>(level)]; }

 private:
  exec::Device device_;
  Camera camera_;
  exec::Buffer<LensPosition> lens_positions_;  // empty where the lens does not distort
  exec::Buffer<float> recorded_;
  std::array<IntensityLevel, kIntensityLevels> levels_;
};

}  // namespace kt
