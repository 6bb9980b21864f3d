// Copies depth, and makes points and normals of it.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/tracking/frame_view.h"

#include "onboard/preprocess/surface_kernel.h"
#include "onboard/tracking/frame_view_kernel.h"
#include "shared/exec/for_each.h"

namespace kt {
namespace {

constexpr int kLevel = kPyramidLevels - 1;

}  // namespace

FrameViews::FrameViews(const exec::Device& device, const Calibration& calibration)
    : device_(device), camera_(calibration.depth.pinhole()) {
  for (int level = 0; level < kLevel; ++level) camera_ = camera_.half();
  view_.camera = camera_;
  view_.points = {device, camera_.pixel_count()};
  view_.normals = {device, camera_.pixel_count()};
}

KeptSurface keep_surface(const exec::Device& device, const FrameMaps& maps, KeptSurface memory) {
  const SurfaceLevel& level = maps.levels[kLevel];
  if (memory.depth.size() == 0)
    memory.depth = {device, DepthView::padded_size(level.camera.width, level.camera.height)};
  memory.normal_step = level.normal_step;
  memory.max_slope = level.max_slope;
  exec::for_each(device, memory.depth.size(), CopyFloats{level.depth.data(), memory.depth.data()});
  return memory;
}

const ModelView& FrameViews::view(const KeptSurface& surface, const Pose& T_odom_camera) {
  const DepthView depth{surface.depth.data(), camera_.width, camera_.height};
  view_.T_odom_camera = T_odom_camera;
  exec::for_each_pixel(
      device_, camera_.width, camera_.height,
      ComputeNormal{depth, camera_, surface.normal_step, surface.max_slope, view_.normals.data()});
  exec::for_each_pixel(device_, camera_.width, camera_.height,
                       UnprojectDepth{depth, camera_, view_.normals.data(), view_.points.data()});
  return view_;
}

}  // namespace kt
