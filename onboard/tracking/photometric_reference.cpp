// Rates every pixel, lists those picked, gathers them.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/tracking/photometric_reference.h"

#include "shared/core/check.h"
#include "shared/exec/compact.h"
#include "shared/exec/for_each.h"

namespace kt {
namespace {

// Less is noise: an image of 2 x 2 means has some two grey levels of it.
constexpr float kMinGradient = 4.0f;  // grey levels per pixel

constexpr float kCauchySigmas = 2.5f;

}  // namespace

PhotometricReference::PhotometricReference(const exec::Device& device, const Calibration& calibration,
                                           int64_t model_pixels)
    : device_(device),
      T_colour_depth_(calibration.T_colour_depth),
      candidates_(device, model_pixels),
      picked_(device, model_pixels),
      indices_(device, model_pixels),
      points_{exec::Buffer<Vec4f>(device, model_pixels), exec::Buffer<Vec4f>(device, model_pixels)} {}

void PhotometricReference::take(const FrameMaps& maps, const ModelView& model, const FrameMotion& motion) {
  T_odom_reference_ = model.T_odom_camera;
  counts_ = {};
  if (!maps.has_colour) return;
  const SurfaceLevel& measured = maps.levels[1];  // of the model view's resolution
  KT_CHECK(measured.camera.width == model.camera.width && measured.camera.height == model.camera.height);
  for (int level = 0; level < 2; ++level) {
    const IntensityLevel& intensity = maps.intensity.level(level);
    const int64_t pixels = model.camera.pixel_count();
    exec::for_each(
        device_, pixels,
        RatePhotometricPoint{model.points.data(), measured.depth_view(), measured.camera, 1 << level,
                             to_rigid3f(T_colour_depth_ * motion.T_depth_colour_time().inverse()),
                             intensity.view(), intensity.camera, kMinGradient, candidates_.data(),
                             picked_.data(), motion.colour_rows(intensity.camera, T_colour_depth_)});
    const int64_t count = exec::compact_flags(device_, picked_.data(), pixels, indices_.data());
    exec::Buffer<Vec4f>& points = points_[static_cast<size_t>(level)];
    exec::for_each(device_, count,
                   GatherPhotometricPoint{candidates_.data(), indices_.data(), points.data()});
    counts_[static_cast<size_t>(level)] = count;
  }
}

PhotometricResidual PhotometricReference::residual(const FrameMaps& maps, int level, const Pose& T_odom_model,
                                                   const Pose& T_model_current, const Exposure& exposure,
                                                   float sigma, const FrameMotion& motion) const {
  const IntensityLevel& intensity = maps.intensity.level(level);
  return {points_[static_cast<size_t>(level)].data(),
          to_rigid3f(T_odom_model.inverse() * T_odom_reference_),
          to_rigid3f(T_colour_depth_ * (T_model_current * motion.T_depth_colour_time()).inverse()),
          {intensity.view(), intensity.camera, exposure, sigma, kCauchySigmas,
           motion.colour_rows(intensity.camera, T_colour_depth_)}};
}

}  // namespace kt
