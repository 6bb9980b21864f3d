// Where bricks go as the volume moves, and the tiles that it is read out in.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/reintegration/reintegrator.h"

#include <cmath>
#include <set>
#include <tuple>
#include <utility>
#include <vector>

namespace kt {
namespace {

int floor_div(int a, int n) { return a / n - (a % n != 0 && (a < 0) != (n < 0)); }

Vec3i voxel_of(Vec3i brick) { return {brick.x * kBrickSide, brick.y * kBrickSide, brick.z * kBrickSide}; }

Vec3i uniform(int x) { return {x, x, x}; }

// What `cells` owns of a slice.
CloudSlice part_within(const CloudSlice& slice, const VoxelBounds& cells) {
  std::vector<uint32_t> triangles;
  for (uint32_t t = 0; t < slice.triangles.size(); ++t) {
    const auto [a, b, c] = slice.triangles[t];
    if (cells.contains(owning_cell({slice.vertices[a].key, slice.vertices[b].key, slice.vertices[c].key})))
      triangles.push_back(t);
  }
  return part_of(slice, triangles);
}

}  // namespace

Reintegrator::Reintegrator(const exec::Device& device, const Calibration& calibration,
                           const ReintegrationConfig& config, const std::filesystem::path& scratch)
    : config_(config),
      preprocessor_(device, calibration, config.preprocess),
      volume_(device, calibration.depth.pinhole(), config.volume),
      store_(scratch) {}

void Reintegrator::fuse(const RgbdFrame& frame, const Pose& T_world_camera, const Vector6d& velocity) {
  if (const auto place = volume_.next_place(T_world_camera)) {
    volume_.move_to(*place, [this](auto bricks) { store_.put(bricks); });
    const VoxelBounds inside = bounds_at(*place);
    store_.read(inside, [this](auto bricks) { volume_.put(bricks); });
    store_.erase(inside);  // a surface may turn out to be none
  }
  maps_ = &preprocessor_.process(frame);
  volume_.integrate(*maps_, T_world_camera, frame.sequence, FrameMotion(*maps_, velocity));
  last_us_ = frame.timestamp_us;
}

bool Reintegrator::shows(const Image<uint16_t>& keyframe_depth) const {
  // Other limits of the depth leave out other pixels, and other filters give other millimetres.
  constexpr float kAgreement = 0.05f;  // of the depth
  const SurfaceLevel& level = maps_->levels[2];
  const std::vector<float> metres = level.depth.downloaded();
  const DepthView view{metres.data(), level.camera.width, level.camera.height};
  if (keyframe_depth.width() != view.width || keyframe_depth.height() != view.height) return false;
  int64_t both = 0, agreeing = 0;
  for (int v = 0; v < view.height; ++v) {
    for (int u = 0; u < view.width; ++u) {
      const float expected = 0.001f * static_cast<float>(keyframe_depth(u, v)), z = view.at(u, v);
      if (expected <= 0 || z <= 0) continue;
      ++both;
      agreeing += std::abs(z - expected) < kAgreement * expected;
    }
  }
  return both > 0 && 2 * agreeing > both;
}

VoxelBounds Reintegrator::bounds_at(Vec3i origin_brick) const {
  const Vec3i low = voxel_of(origin_brick);
  return {low, low + uniform(config_.volume.resolution)};
}

// A tile owns what lies one block from the sides of the volume: its vertices are made of voxels that are
// there.
CloudSlice Reintegrator::tile_at(Vec3i low_brick) {
  const Vec3i origin = low_brick - uniform(kBlockSide);
  volume_.move_to(origin, [](auto) {});
  store_.read(bounds_at(origin), [this](auto bricks) { volume_.put(bricks); });
  const Vec3i low = voxel_of(low_brick);
  return part_within(volume_.flush(), {low, low + uniform(kBrickSide * owned_bricks())});
}

int Reintegrator::tile_side() const { return owned_bricks() * kBrickSide; }

int Reintegrator::owned_bricks() const { return config_.volume.resolution / kBrickSide - 2 * kBlockSide; }

void Reintegrator::extract(const std::function<void(CloudSlice)>& take,
                           const std::function<void(double)>& progress) {
  volume_.take_all([this](auto bricks) { store_.put(bricks); });
  const int owned = owned_bricks();
  std::set<std::tuple<int, int, int>> tiles;
  for (const Vec3i b : store_.blocks()) {
    tiles.emplace(floor_div(b.z * kBlockSide, owned), floor_div(b.y * kBlockSide, owned),
                  floor_div(b.x * kBlockSide, owned));
  }
  int64_t sequence = 0;
  for (const auto& [z, y, x] : tiles) {
    CloudSlice slice = tile_at({x * owned, y * owned, z * owned});
    slice.sequence = sequence++;
    slice.timestamp_us = last_us_;
    slice.is_final = sequence == static_cast<int64_t>(tiles.size());
    take(std::move(slice));
    progress(static_cast<double>(sequence) / static_cast<double>(tiles.size()));
  }
}

}  // namespace kt
