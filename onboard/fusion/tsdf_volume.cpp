// Host side of the volume: which kernels run on which bricks, and where the volume stands.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/fusion/tsdf_volume.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "onboard/fusion/raycast_kernel.h"
#include "shared/core/digest.h"
#include "shared/exec/compact.h"
#include "shared/exec/for_each.h"

namespace kt {
namespace {

// A small volume follows sooner than configured, lest its aim point leave it, and aims nearer, lest the
// camera do.
constexpr double kLargestShiftShare = 0.3, kLargestAimShare = 0.4;  // of its edge

int64_t cube(int64_t n) { return n * n * n; }

int checked_bricks(const VolumeConfig& config) {
  if (config.resolution < kBlockVoxels || config.resolution > 2048 || config.resolution % kBlockVoxels != 0) {
    throw Error("volume.resolution must be a multiple of 32 between 32 and 2048, got " +
                std::to_string(config.resolution));
  }
  return config.resolution / kBrickSide;
}

int tiles_across(int pixels, int side) { return (pixels + side - 1) / side; }

int modulo(int a, int n) { return (a % n + n) % n; }

}  // namespace

TsdfVolume::TsdfVolume(const exec::Device& device, const PinholeParams& camera, const VolumeConfig& config)
    : device_(device),
      camera_(camera),
      config_(config),
      bricks_(checked_bricks(config)),
      voxels_(device, cube(config.resolution)),
      colours_(device, cube(config.resolution)),
      surface_masks_(device, cube(bricks_) * kBrickColumns),
      brick_states_(device, cube(bricks_)),
      brick_last_seen_(device, cube(bricks_)),
      tile_rows_(device, int64_t{tiles_across(camera.width, kTileSide)} * camera.height),
      tiles_(device, int64_t{tiles_across(camera.width, kTileSide)} * tiles_across(camera.height, kTileSide)),
      selected_(device, cube(bricks_)),
      slots_(device, cube(bricks_)),
      fused_columns_(device, cube(bricks_) * kBrickColumns),
      brick_distances_(device, bricks_),
      ray_stretches_(device, int64_t{tiles_across(camera.width, kRayTileSide)} *
                                 tiles_across(camera.height, kRayTileSide)),
      model_view_{camera.half(),
                  Pose::Identity(),
                  Pose::Identity(),
                  0.5 * config.resolution * config.voxel_size_m,
                  {device, camera.half().pixel_count()},
                  {device, camera.half().pixel_count()}},
      extractor_(device, cube(bricks_)) {}

VolumeView TsdfVolume::view() const {
  // Kernels take mutable pointers; const methods only read through them.
  auto& self = const_cast<TsdfVolume&>(*this);
  return {
      self.voxels_.data(),
      self.colours_.data(),
      self.surface_masks_.data(),
      self.brick_states_.data(),
      self.brick_last_seen_.data(),
      bricks_,
      origin_brick_,
      {modulo(origin_brick_.x, bricks_), modulo(origin_brick_.y, bricks_), modulo(origin_brick_.z, bricks_)},
      static_cast<float>(config_.voxel_size_m),
      static_cast<float>(config_.truncation_voxels * config_.voxel_size_m)};
}

Pose TsdfVolume::T_volume_odom() const {
  const double brick_m = kBrickSide * config_.voxel_size_m;
  Pose T = Pose::Identity();
  T.translation() = -brick_m * Eigen::Vector3d(origin_brick_.x, origin_brick_.y, origin_brick_.z);
  return T;
}

void TsdfVolume::integrate(const FrameMaps& maps, const Pose& T_odom_camera, int64_t frame_sequence,
                           const FrameMotion& motion) {
  const VolumeView volume = view();
  const RowMotion rows = motion.depth_rows(camera_);
  const Rigid3f T_camera_volume = to_rigid3f((T_volume_odom() * T_odom_camera).inverse());
  const int tiles_per_row = tiles_across(camera_.width, kTileSide);
  exec::for_each_pixel(device_, tiles_per_row, camera_.height,
                       TileRowDepthRange{maps.fusion_pixels.data(), camera_.width, tile_rows_.data()});
  exec::for_each_pixel(device_, tiles_per_row, tiles_across(camera_.height, kTileSide),
                       TileDepthRange{tile_rows_.data(), tiles_per_row, camera_.height, tiles_.data()});
  exec::for_each_lane<SelectBricks::kBlockBricks>(
      device_, cube(bricks_),
      SelectBricks{volume, camera_, T_camera_volume, tiles_.data(), selected_.data(), rows});
  const int64_t bricks = exec::compact_flags(device_, selected_.data(), selected_.size(), slots_.data());
  exec::for_each_lane(
      device_, bricks * kBrickColumns,
      FuseColumns{volume, camera_, T_camera_volume, slots_.data(), maps.fusion_pixels.data(),
                  maps.has_colour ? maps.registered_colour.data() : nullptr,
                  static_cast<float>(config_.max_weight) * Voxel::kWeightUnits, fused_columns_.data(), rows});
  exec::for_each(
      device_, bricks,
      SummariseBrick{volume, slots_.data(), fused_columns_.data(), static_cast<uint32_t>(frame_sequence)});
}

const ModelView& TsdfVolume::raycast(const Pose& T_odom_camera) {
  model_view_.T_odom_camera = T_odom_camera;
  model_view_.T_middle_camera = Eigen::Translation3d(Eigen::Vector3d::Constant(-model_view_.half_edge_m)) *
                                T_volume_odom() * T_odom_camera;
  const VolumeView volume = view();
  const Rigid3f T_volume_camera = to_rigid3f(T_volume_odom() * T_odom_camera);
  constexpr float kNearestM = 0.1f, kFarthestM = 100.0f;  // the volume ends sooner
  brick_distances_.measure(brick_states_.data());
  const PinholeParams& camera = model_view_.camera;
  exec::for_each_pixel(device_, tiles_across(camera.width, kRayTileSide),
                       tiles_across(camera.height, kRayTileSide),
                       RaycastTile{volume, brick_distances_.by_slot().data(), camera, T_volume_camera,
                                   kNearestM, kFarthestM, ray_stretches_.data()});
  exec::for_each_lane<exec::kWideLanes>(device_, RaycastPixel::element_count(camera),
                                        RaycastPixel{{volume},
                                                     brick_distances_.by_slot().data(),
                                                     camera,
                                                     T_volume_camera,
                                                     kNearestM,
                                                     kFarthestM,
                                                     ray_stretches_.data(),
                                                     model_view_.points.data(),
                                                     model_view_.normals.data()});
  return model_view_;
}

Eigen::Vector3d TsdfVolume::aim_point(const Pose& T_odom_camera) const {
  const double edge_m = config_.resolution * config_.voxel_size_m;
  return T_odom_camera * Eigen::Vector3d(0, 0, std::min(config_.aim_distance_m, kLargestAimShare * edge_m));
}

Vec3i TsdfVolume::wanted_origin_brick(const Pose& T_odom_camera) const {
  const Eigen::Vector3d aim = aim_point(T_odom_camera);
  const double block_m = kBlockVoxels * config_.voxel_size_m;
  const Eigen::Vector3d low = aim.array() - 0.5 * config_.resolution * config_.voxel_size_m;
  // An axis stays where it is unless it is off by more than rounding can be: one that hardly moves must not
  // go to and fro between two blocks, for each return would export the same place once more.
  const auto brick = [&](double coordinate_m, int current) {
    constexpr double kStaysWithin = 0.75;
    const double blocks = coordinate_m / block_m;
    const bool stays =
        placed_ && std::abs(blocks - static_cast<double>(current) / kBlockSide) <= kStaysWithin;
    return stays ? current : kBlockSide * static_cast<int>(std::lround(blocks));
  };
  return {brick(low.x(), origin_brick_.x), brick(low.y(), origin_brick_.y), brick(low.z(), origin_brick_.z)};
}

std::optional<Vec3i> TsdfVolume::next_place(const Pose& T_odom_camera) const {
  const Vec3i wanted = wanted_origin_brick(T_odom_camera);
  if (!placed_) return wanted;
  const Eigen::Vector3d aim = aim_point(T_odom_camera);
  const Eigen::Vector3d centre =
      T_volume_odom().inverse() * Eigen::Vector3d::Constant(0.5 * config_.resolution * config_.voxel_size_m);
  const double edge_m = config_.resolution * config_.voxel_size_m;
  const double shift_distance_m = std::min(config_.shift_distance_m, kLargestShiftShare * edge_m);
  if ((aim - centre).norm() < shift_distance_m || wanted == origin_brick_) return std::nullopt;
  return wanted;
}

VoxelBounds TsdfVolume::bounds_at(Vec3i origin_brick) const {
  const Vec3i low{origin_brick.x * kBrickSide, origin_brick.y * kBrickSide, origin_brick.z * kBrickSide};
  return {low, low + Vec3i{config_.resolution, config_.resolution, config_.resolution}};
}

std::optional<CloudSlice> TsdfVolume::follow(const Pose& T_odom_camera) {
  const std::optional<Vec3i> place = next_place(T_odom_camera);
  std::optional<CloudSlice> slice;
  if (place && placed_) {
    const VoxelBounds after = bounds_at(*place);
    slice = extractor_.extract(
        {view(), after, static_cast<int32_t>(std::lround(config_.min_slice_weight * Voxel::kWeightUnits))});
    slice->T_odom_camera = T_odom_camera;
    give_back_outside(after);
  }
  if (place) origin_brick_ = *place;
  placed_ = true;
  return slice;
}

void TsdfVolume::take_outside(const VoxelBounds& after, const KeepBricks& keep) {
  constexpr int64_t kAtOnce = 4096;
  exec::Buffer<uint8_t> with_surface(device_, selected_.size());
  exec::for_each(device_, selected_.size(),
                 SelectLeavingBrick{view(), after, selected_.data(), with_surface.data()});
  const int64_t stored =
      exec::compact_flags(device_, with_surface.data(), with_surface.size(), slots_.data());
  exec::Buffer<StoredBrick> bricks(device_, std::min(stored, kAtOnce));
  for (int64_t first = 0; first < stored; first += kAtOnce) {
    const int64_t count = std::min(kAtOnce, stored - first);
    exec::for_each(device_, count * kBrickColumns,
                   StoreBrickRow{view(), slots_.data() + first, bricks.data()});
    keep(bricks.downloaded(count));
  }
  const int64_t leaving = exec::compact_flags(device_, selected_.data(), selected_.size(), slots_.data());
  exec::for_each(device_, leaving, ClearBrick{view(), after, slots_.data()});
  give_back_outside(after);
}

void TsdfVolume::move_to(Vec3i origin_brick, const KeepBricks& keep) {
  if (placed_) take_outside(bounds_at(origin_brick), keep);
  origin_brick_ = origin_brick;
  placed_ = true;
}

void TsdfVolume::take_all(const KeepBricks& keep) {
  take_outside({}, keep);
  placed_ = false;
}

void TsdfVolume::put(std::span<const StoredBrick> bricks) {
  const VoxelBounds bounds = bounds_at(origin_brick_);
  std::vector<StoredBrick> inside;
  for (const StoredBrick& stored : bricks) {
    const Vec3i b = stored.brick;
    if (bounds.contains({b.x * kBrickSide, b.y * kBrickSide, b.z * kBrickSide})) inside.push_back(stored);
  }
  exec::Buffer<StoredBrick> buffer(device_, static_cast<int64_t>(inside.size()));
  buffer.upload(inside);
  exec::for_each(device_, buffer.size() * kBrickColumns, RestoreBrickRow{view(), buffer.data()});
}

void TsdfVolume::give_back_outside(const VoxelBounds& after) {
  const VolumeView volume = view();
  const auto leaves = [&](Vec3i b) {
    return !after.contains(volume.origin_voxel() +
                           Vec3i{b.x * kBrickSide, b.y * kBrickSide, b.z * kBrickSide});
  };
  for (int64_t begin = 0, end = 0; begin < brick_states_.size(); begin = end) {
    end = begin + 1;
    if (!leaves(volume.brick(begin))) continue;
    while (end < brick_states_.size() && leaves(volume.brick(end))) ++end;
    voxels_.give_back_zeros(begin * kBrickVoxels, (end - begin) * kBrickVoxels);
    colours_.give_back_zeros(begin * kBrickVoxels, (end - begin) * kBrickVoxels);
  }
}

CloudSlice TsdfVolume::flush() {
  const VoxelBounds nothing{};
  CloudSlice slice = extractor_.extract(
      {view(), nothing, static_cast<int32_t>(std::lround(config_.min_slice_weight * Voxel::kWeightUnits))});
  give_back_outside(nothing);
  placed_ = false;
  return slice;
}

uint64_t TsdfVolume::digest() const {
  Digest digest;
  digest.add(std::span<const Voxel>(voxels_.downloaded()));
  digest.add(std::span<const ColourVoxel>(colours_.downloaded()));
  return digest.value();
}

}  // namespace kt
