// The order of the preprocessing kernels.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/preprocess/preprocessor.h"

#include <cmath>
#include <numbers>
#include <vector>

#include "onboard/preprocess/correct_colour_kernel.h"
#include "onboard/preprocess/depth_kernel.h"
#include "onboard/preprocess/occlusion_kernel.h"
#include "shared/exec/for_each.h"

namespace kt {
namespace {

// Nearest recorded pixel of each pixel of the undistorted camera, -1 where it lies outside the image.
std::vector<int32_t> undistortion_table(const Camera& camera) {
  std::vector<int32_t> table;
  table.reserve(static_cast<size_t>(camera.width) * camera.height);
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      const Eigen::Vector2d source =
          camera.project({(u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, 1.0});
      const double x = std::round(source.x()), y = std::round(source.y());
      const bool inside = x >= 0 && y >= 0 && x < camera.width && y < camera.height;
      table.push_back(inside ? static_cast<int32_t>(y) * camera.width + static_cast<int32_t>(x) : -1);
    }
  }
  return table;
}

bool shares_viewpoint(const Calibration& calibration) {
  return calibration.T_colour_depth.matrix() == Pose::Identity().matrix();
}

}  // namespace

Preprocessor::Preprocessor(const exec::Device& device, const Calibration& calibration,
                           const PreprocessConfig& config)
    : device_(device), calibration_(calibration), config_(config), camera_(calibration.depth.pinhole()) {
  if (const std::string problem = calibration.problem(); !problem.empty()) {
    throw Error("calibration '" + calibration.name + "': " + problem);
  }
  const int64_t pixels = camera_.pixel_count();
  raw_depth_ = {device, pixels};
  undistortion_ = {device, pixels};
  undistortion_.upload(undistortion_table(calibration.depth));
  measured_depth_ = {device, DepthView::padded_size(camera_.width, camera_.height)};
  colour_ = {device, calibration.colour.pinhole().pixel_count()};
  colour_positions_ = {device, pixels};
  maps_.fusion_pixels = {device, pixels};
  maps_.registered_colour = {device, pixels};
  maps_.intensity = {device, calibration.colour};
  PinholeParams camera = camera_;
  int32_t normal_step = 3;  // 3, 2 and 1 pixels: with less, the disparity steps of the sensor show
  for (SurfaceLevel& level : maps_.levels) {
    level.camera = camera;
    level.normal_step = normal_step--;
    level.max_slope = max_slope_of(camera, config_.max_view_angle_deg);
    level.depth = {device, DepthView::padded_size(camera.width, camera.height)};
    level.normals = {device, camera.pixel_count()};
    camera = camera.half();
  }
  if (shares_viewpoint(calibration)) {
    exec::Buffer<float> far(device, DepthView::padded_size(camera_.width, camera_.height));
    far.upload(std::vector<float>(static_cast<size_t>(far.size()), 1.0f));
    find_colour_positions({far.data(), camera_.width, camera_.height});
  } else {
    nearest_in_tiles_ = {device,
                         int64_t{NearestInTile::tiles(camera_.width)} * NearestInTile::tiles(camera_.height)};
  }
}

void Preprocessor::find_colour_positions(const DepthView& depth) {
  exec::for_each_pixel(device_, camera_.width, camera_.height,
                       FindColourPosition{depth, camera_, to_rigid3f(calibration_.T_colour_depth),
                                          calibration_.colour.distorted_pinhole(), colour_positions_.data()});
}

void Preprocessor::hide_from_colour(const DepthView& depth) {
  const int tiles_u = NearestInTile::tiles(camera_.width), tiles_v = NearestInTile::tiles(camera_.height);
  exec::for_each_pixel(device_, tiles_u, tiles_v, NearestInTile{depth, nearest_in_tiles_.data()});
  exec::for_each_pixel(device_, tiles_u, camera_.height,
                       HideFromColour{depth, camera_, to_rigid3f(calibration_.T_colour_depth.inverse()).t,
                                      static_cast<float>(config_.depth_min_m), nearest_in_tiles_.data(),
                                      colour_positions_.data()});
}

const FrameMaps& Preprocessor::process(const RgbdFrame& frame) {
  KT_CHECK(frame.depth.width() == camera_.width && frame.depth.height() == camera_.height,
           "depth image of another size than the calibration's");
  KT_CHECK(frame.colour.empty() || (frame.colour.width() == calibration_.colour.width &&
                                    frame.colour.height() == calibration_.colour.height),
           "colour image of another size than the calibration's");
  const DepthView measured{measured_depth_.data(), camera_.width, camera_.height};
  SurfaceLevel& full = maps_.levels[0];

  maps_.timestamp_us = frame.timestamp_us;
  maps_.colour_timestamp_us = frame.colour_timestamp_us + std::llround(calibration_.colour_delay_s * 1e6);
  maps_.readout_s = calibration_.readout_s;
  raw_depth_.upload(frame.depth.pixels());
  exec::for_each_pixel(
      device_, camera_.width, camera_.height,
      ConvertDepth{raw_depth_.data(), undistortion_.data(), static_cast<float>(calibration_.depth_unit_m),
                   calibration_.invalid_depth, static_cast<float>(config_.depth_min_m),
                   static_cast<float>(config_.depth_max_m), measured, measured_depth_.data()});

  BilateralFilter filter{measured, {}, static_cast<float>(config_.bilateral_range_sigmas), full.depth.data()};
  for (int k = -BilateralFilter::kRadius; k <= BilateralFilter::kRadius; ++k) {
    const double scaled = k / config_.bilateral_sigma_px;
    filter.spatial[k + BilateralFilter::kRadius] = static_cast<float>(std::exp(-0.5 * scaled * scaled));
  }
  exec::for_each_pixel(device_, camera_.width, camera_.height, filter);

  for (int l = 0; l < kPyramidLevels; ++l) {
    SurfaceLevel& level = maps_.levels[static_cast<size_t>(l)];
    const PinholeParams& camera = level.camera;
    if (l > 0) {
      const SurfaceLevel& finer = maps_.levels[static_cast<size_t>(l - 1)];
      exec::for_each_pixel(
          device_, camera.width, camera.height,
          HalveDepth{finer.depth_view(), level.depth_view(), finer.max_slope, level.depth.data()});
    }
    exec::for_each_pixel(
        device_, camera.width, camera.height,
        ComputeNormal{level.depth_view(), camera, level.normal_step, level.max_slope, level.normals.data()});
  }

  maps_.has_colour = !frame.colour.empty();
  if (maps_.has_colour) {
    colour_.upload(frame.colour.pixels());
    maps_.intensity.build(colour_.data());
    // Seen from the same place, a point stays at its pixel whatever its depth: the constructor has found it.
    if (!shares_viewpoint(calibration_)) {
      find_colour_positions(full.depth_view());
      hide_from_colour(full.depth_view());
    }
    exec::for_each_pixel(
        device_, camera_.width, camera_.height,
        SampleColour{full.depth_view(), colour_positions_.data(), calibration_.colour.width,
                     calibration_.colour.height, colour_.data(), maps_.registered_colour.data()});
  }
  exec::for_each_pixel(
      device_, camera_.width, camera_.height,
      MakeFusionPixel{measured, camera_, full.normals.data(),
                      static_cast<float>(std::cos(config_.max_view_angle_deg * std::numbers::pi / 180)),
                      max_slope_of(camera_, config_.max_view_angle_deg), maps_.fusion_pixels.data()});
  return maps_;
}

void Preprocessor::correct_colour(Vec3f factor) {
  KT_CHECK(factor.x > 0 && factor.y > 0 && factor.z > 0, "a colour's factor must be positive");
  if (!maps_.has_colour) return;
  exec::for_each(device_, maps_.registered_colour.size(),
                 CorrectColour{factor, maps_.registered_colour.data()});
}

}  // namespace kt
