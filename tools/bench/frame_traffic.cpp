// What changed in the volume, on the device; what a prediction rests on, on the host.
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/bench/frame_traffic.h"

#include <cmath>

#include "shared/exec/compact.h"
#include "shared/exec/for_each.h"

namespace kt::bench {
namespace {

int64_t brick_count(const VolumeView& view) { return int64_t{view.bricks} * view.bricks * view.bricks; }

int64_t count_surface_rows(const VolumeView& view, const ModelView& model) {
  std::vector<bool> is_read(static_cast<size_t>(brick_count(view) * kBrickRows));
  int64_t rows = 0;
  const Vec3i origin = view.origin_voxel();
  for (const Vec4f& point : model.points.downloaded()) {
    if (point.w <= 0) continue;
    const Eigen::Vector3d voxel = model.T_odom_camera * Eigen::Vector3d(point.x, point.y, point.z) /
                                  static_cast<double>(view.voxel_size_m);
    const Vec3i low{static_cast<int32_t>(std::floor(voxel.x())) - origin.x,
                    static_cast<int32_t>(std::floor(voxel.y())) - origin.y,
                    static_cast<int32_t>(std::floor(voxel.z())) - origin.z};
    for (int k = 0; k < 8; ++k) {
      const Vec3i corner = low + Vec3i{k & 1, k >> 1 & 1, k >> 2};
      if (!view.contains(corner)) continue;  // for rounding only: the surface lies inside
      const auto row = static_cast<size_t>(view.index(corner) / kBrickSide);
      if (!is_read[row]) ++rows;
      is_read[row] = true;
    }
  }
  return rows;
}

}  // namespace

TrafficCount::TrafficCount(const exec::Device& device, const TsdfVolume& volume)
    : device_(device),
      bricks_(brick_count(volume.view())),
      rows_(device, bricks_ * kBrickRows),
      voxel_rows_(device, bricks_),
      colour_rows_(device, bricks_),
      offsets_(device, bricks_) {}

void TrafficCount::start(const TsdfVolume& volume) {
  exec::for_each(device_, bricks_, RememberRows{volume.view(), rows_.data()});
}

FrameTraffic TrafficCount::finish(const TsdfVolume& volume, const FrameMaps& maps, const ModelView& model) {
  constexpr int64_t kVoxelRowBytes = kBrickSide * sizeof(Voxel),
                    kColourRowBytes = kBrickSide * sizeof(ColourVoxel);
  exec::for_each(device_, bricks_,
                 CountChangedRows{volume.view(), rows_.data(), voxel_rows_.data(), colour_rows_.data()});
  FrameTraffic traffic;
  traffic.voxel_rows = exec::exclusive_scan(device_, voxel_rows_.data(), bricks_, offsets_.data());
  traffic.colour_rows = exec::exclusive_scan(device_, colour_rows_.data(), bricks_, offsets_.data());
  traffic.surface_rows = count_surface_rows(volume.view(), model);
  traffic.integrate_bytes =
      2 * (traffic.voxel_rows * kVoxelRowBytes + traffic.colour_rows * kColourRowBytes) +
      maps.fusion_pixels.size() * static_cast<int64_t>(sizeof(FusionPixel));
  traffic.raycast_bytes = traffic.surface_rows * kVoxelRowBytes + bricks_ +
                          (model.points.size() + model.normals.size()) * static_cast<int64_t>(sizeof(Vec4f));
  return traffic;
}

}  // namespace kt::bench
