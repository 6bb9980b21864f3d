// Copies depth, and makes points and normals of it.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/tracking/frame_view.h"

#include "onboard/preprocess/surface_kernel.h"
#include "onboard/tracking/frame_view_kernel.h"
#include "shared/exec/for_each.h"

namespace kt {
namespace {

constexpr int kLevel = kPyramidLevels - 1;

PinholeParams coarsest(const Calibration& calibration) {
  return calibration.depth.pinhole().at_level(kLevel);
}

}  // namespace

SurfaceMemory::SurfaceMemory(const exec::Device& device, const Calibration& calibration, int64_t capacity)
    : device_(device),
      depths_(device, DepthView::padded_size(coarsest(calibration).width, coarsest(calibration).height),
              capacity) {}

KeptSurface SurfaceMemory::keep(const FrameMaps& maps, const FrameMotion& motion) {
  const SurfaceLevel& level = maps.levels[kLevel];
  KT_CHECK(level.depth.size() == depths_.block_size());
  KeptSurface kept{depths_.take(), level.normal_step, level.max_slope, motion.depth_rows(level.camera)};
  exec::for_each(device_, depths_.block_size(), CopyFloats{level.depth.data(), kept.depth.get()});
  return kept;
}

FrameViews::FrameViews(const exec::Device& device, const Calibration& calibration)
    : device_(device), camera_(coarsest(calibration)) {
  view_.camera = camera_;
  view_.points = {device, camera_.pixel_count()};
  view_.normals = {device, camera_.pixel_count()};
}

const ModelView& FrameViews::view(const KeptSurface& surface, const Pose& T_odom_camera) {
  const DepthView depth{surface.depth.get(), camera_.width, camera_.height};
  view_.T_odom_camera = T_odom_camera;
  exec::for_each_pixel(
      device_, camera_.width, camera_.height,
      ComputeNormal{depth, camera_, surface.normal_step, surface.max_slope, view_.normals.data()});
  exec::for_each_pixel(
      device_, camera_.width, camera_.height,
      UnprojectDepth{depth, camera_, view_.normals.data(), view_.points.data(), surface.shutter});
  return view_;
}

}  // namespace kt
