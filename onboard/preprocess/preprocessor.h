// Runs the preprocessing kernels and owns their outputs.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cmath>
#include <numbers>

#include "onboard/preprocess/depth_map.h"
#include "onboard/preprocess/intensity_pyramid.h"
#include "onboard/preprocess/surface_kernel.h"
#include "shared/exec/buffer.h"
#include "shared/types/calibration.h"
#include "shared/types/rgbd_frame.h"

namespace kt {

inline constexpr int kPyramidLevels = 3;

/// |dz| / z per pixel of a surface seen at `angle`: a steeper change is a jump to another surface.
inline float max_slope_of(const PinholeParams& camera, double angle_deg) {
  return static_cast<float>(std::tan(angle_deg * std::numbers::pi / 180) / static_cast<double>(camera.fx));
}

struct PreprocessConfig {
  double depth_min_m = 0.3;           ///< nearer measurements are dropped
  double depth_max_m = 6.0;           ///< farther measurements are dropped
  double bilateral_sigma_px = 1.5;    ///< spatial scale of the filter
  double bilateral_range_sigmas = 4;  ///< range scale in standard deviations of the depth noise
  double max_view_angle_deg = 80;     ///< measurements seen at a more grazing angle are not fused
};

/// One level of the measured surface, in the undistorted depth camera of that level.
struct SurfaceLevel {
  PinholeParams camera;
  exec::Buffer<float> depth;    ///< filtered, bordered; read through `depth_view()`
  exec::Buffer<Vec4f> normals;  ///< camera frame, w = validity
  int32_t normal_step = 1;      ///< how the normals were made, see ComputeNormal
  float max_slope = 0;
  DepthView depth_view() const { return {depth.data(), camera.width, camera.height}; }
};

/// Everything the later stages read of one frame; lives on the device and is overwritten by the next frame.
struct FrameMaps {
  int64_t timestamp_us = 0, colour_timestamp_us = 0;  ///< of the depth and of the colour image
  std::array<SurfaceLevel, kPyramidLevels> levels;    ///< 0 = full resolution
  exec::Buffer<FusionPixel> fusion_pixels;            ///< full resolution
  /// Colour of each pixel of the depth camera, r in the low byte; a = 0 where there is none. Of an earlier
  /// frame without colour.
  exec::Buffer<uint32_t> registered_colour;
  IntensityPyramid intensity;  ///< of the colour camera; of an earlier frame without colour
  bool has_colour = false;
  double readout_s = 0;  ///< as Calibration::readout_s
};

class Preprocessor {
 public:
  /// Allocates for images of the calibration's sizes. Throws kt::Error for a calibration that makes no sense.
  Preprocessor(const exec::Device& device, const Calibration& calibration, const PreprocessConfig& config);

  /// Image sizes must be the calibration's; colour may be empty. The result stays valid until the next call.
  const FrameMaps& process(const RgbdFrame& frame);

 private:
  void find_colour_positions(const DepthView& depth);
  void hide_from_colour(const DepthView& depth);

  exec::Device device_;
  Calibration calibration_;
  PreprocessConfig config_;
  PinholeParams camera_;
  exec::Buffer<uint16_t> raw_depth_;
  exec::Buffer<int32_t> undistortion_;  // source pixel of each undistorted depth pixel
  exec::Buffer<float> measured_depth_;  // bordered
  exec::Buffer<Rgb8> colour_;
  exec::Buffer<ColourPosition> colour_positions_;  // by depth pixel
  exec::Buffer<float> nearest_in_tiles_;           // empty where both cameras share a viewpoint
  FrameMaps maps_;
};

}  // namespace kt
