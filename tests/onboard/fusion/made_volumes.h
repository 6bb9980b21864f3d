// Frames and volumes for the tests of fusion.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <vector>

#include "onboard/fusion/tsdf_volume.h"
#include "tests/support/analytic_scene.h"

namespace kt::test {

/// Frame maps that hold what fusion reads: one pixel and colour for all of the image.
inline FrameMaps uniform_maps(const exec::Device& device, const PinholeParams& camera, FusionPixel pixel,
                              uint32_t rgba = 0xff808080u) {
  const auto pixels = static_cast<size_t>(camera.pixel_count());
  FrameMaps maps;
  maps.fusion_pixels = {device, camera.pixel_count()};
  maps.fusion_pixels.upload(std::vector<FusionPixel>(pixels, pixel));
  maps.registered_colour = {device, camera.pixel_count()};
  maps.registered_colour.upload(std::vector<uint32_t>(pixels, rgba));
  maps.has_colour = true;
  return maps;
}

/// A wall across the view at `depth_m`, seen with `weight`.
inline FusionPixel wall_pixel(float depth_m, float weight = 1) {
  return {depth_m, FusionPixel::packed(1.0f, weight)};
}

/// A scene, a rig that records it and a volume that fuses it.
struct Recorder {
  exec::Device device = exec::Device::cpu(1);
  AnalyticScene scene{};
  Calibration calibration = small_calibration();
  PreprocessConfig preprocess{};
  VolumeConfig config{};
  RenderOptions render_options{};
  Preprocessor preprocessor{device, calibration, preprocess};
  TsdfVolume volume{device, calibration.depth.pinhole(), config};
  int64_t frames = 0;

  /// Records and fuses one frame; shifts first where asked and due.
  void fuse(const Pose& T_odom_camera) {
    render_options.sequence = frames;
    const FrameMaps& maps = preprocessor.process(render(scene, calibration, T_odom_camera, render_options));
    volume.integrate(maps, T_odom_camera, frames++, FrameMotion(maps, render_options.velocity));
  }
};

/// The voxel nearest to a point, of a volume in host memory.
inline Voxel voxel_at(const TsdfVolume& volume, const Eigen::Vector3d& p_odom) {
  const VolumeView view = volume.view();
  const auto round = [&](double x) {
    return static_cast<int32_t>(std::lround(x / static_cast<double>(view.voxel_size_m)));
  };
  const Vec3i local = Vec3i{round(p_odom.x()), round(p_odom.y()), round(p_odom.z())} - view.origin_voxel();
  return view.contains(local) ? view.voxels[view.index(local)] : Voxel{};
}

/// Calls visit(p_odom, voxel, colour) for every observed voxel of a volume in host memory.
template <typename Visit>
void for_each_observed(const TsdfVolume& volume, const Visit& visit) {
  const VolumeView view = volume.view();
  const int n = view.voxels_per_axis();
  for (int z = 0; z < n; ++z) {
    for (int y = 0; y < n; ++y) {
      for (int x = 0; x < n; ++x) {
        const int64_t i = view.index({x, y, z});
        if (view.voxels[i].weight_units() == 0) continue;
        const Vec3i global = Vec3i{x, y, z} + view.origin_voxel();
        visit(Eigen::Vector3d(global.x, global.y, global.z) * static_cast<double>(view.voxel_size_m),
              view.voxels[i], view.colours[i]);
      }
    }
  }
}

}  // namespace kt::test
