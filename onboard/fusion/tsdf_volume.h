// The moving TSDF volume: fuses frames, predicts surface, exports what it leaves behind.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <optional>
#include <span>

#include "onboard/fusion/brick_distances.h"
#include "onboard/fusion/integrate_kernel.h"
#include "onboard/fusion/raycast_kernel.h"
#include "onboard/fusion/select_bricks_kernel.h"
#include "onboard/fusion/slice_extractor.h"
#include "onboard/fusion/stored_brick_kernel.h"
#include "onboard/preprocess/frame_motion.h"
#include "onboard/preprocess/model_view.h"
#include "onboard/preprocess/preprocessor.h"
#include "shared/types/cloud_slice.h"

namespace kt {

struct VolumeConfig {
  int resolution = 512;  ///< voxels per axis, a multiple of 32
  double voxel_size_m = 0.01;
  double truncation_voxels = 4;   ///< truncation distance
  double max_weight = 100;        ///< cap of the running average, in views from 1 m
  double shift_distance_m = 1.5;  ///< the volume follows when its aim point is this far from its centre; at
                                  ///< most 0.3 of its edge
  double aim_distance_m =
      2.0;  ///< the aim point lies this far in front of the camera; at most 0.4 of the edge
  double min_slice_weight = 0.3;  ///< voxels trusted less are not exported
};

class TsdfVolume {
 public:
  /// Memory: 12 bytes per voxel, allocated here; on a CPU physical only where bricks were fused. Throws
  /// kt::Error for an impossible configuration or too little memory.
  TsdfVolume(const exec::Device& device, const PinholeParams& camera, const VolumeConfig& config);

  /// Fuses a frame seen from T_odom_camera by a camera in `motion`. `frame_sequence` is remembered as the
  /// last to see what it touches.
  void integrate(const FrameMaps& maps, const Pose& T_odom_camera, int64_t frame_sequence,
                 const FrameMotion& motion = {});

  /// Predicts the surface seen from T_odom_camera; the result stays valid until the next call.
  const ModelView& raycast(const Pose& T_odom_camera);

  /// Moves the volume where the camera has moved far enough and returns the surface that left it. The model
  /// view must be predicted again afterwards. The first call places the volume and returns nothing.
  std::optional<CloudSlice> follow(const Pose& T_odom_camera);

  /// Exports everything that is left; the volume is empty afterwards, and placed anew by the next follow().
  CloudSlice flush();

  /// Where follow() would place the volume now, by its lowest brick; nothing where it stays.
  std::optional<Vec3i> next_place(const Pose& T_odom_camera) const;

  /// Takes some bricks at a time.
  using KeepBricks = std::function<void(std::span<const StoredBrick>)>;
  /// Places the volume. The bricks that leave it and hold surface are handed over with all that is known of
  /// them, for put() to bring back; what is known of empty space is lost. Nothing is exported, nothing
  /// frozen. `origin_brick`: multiples of kBlockSide.
  void move_to(Vec3i origin_brick, const KeepBricks& keep);
  /// As move_to() does with all of them.
  void take_all(const KeepBricks& keep);
  /// Brings bricks back; those outside the volume are left out. Nothing may have been fused there since.
  void put(std::span<const StoredBrick> bricks);

  Vec3i origin_voxel() const { return view().origin_voxel(); }
  /// Content of the volume for parity tests.
  uint64_t digest() const;
  VolumeView view() const;

 private:
  Pose T_volume_odom() const;
  VoxelBounds bounds_at(Vec3i origin_brick) const;
  void take_outside(const VoxelBounds& after, const KeepBricks& keep);
  /// The cleared bricks outside `after` need no memory until they are fused into again.
  void give_back_outside(const VoxelBounds& after);
  Eigen::Vector3d aim_point(const Pose& T_odom_camera) const;
  Vec3i wanted_origin_brick(const Pose& T_odom_camera) const;

  exec::Device device_;
  PinholeParams camera_;
  VolumeConfig config_;
  int bricks_;  // per axis
  Vec3i origin_brick_;
  bool placed_ = false;
  exec::Buffer<Voxel> voxels_;
  exec::Buffer<ColourVoxel> colours_;
  exec::Buffer<uint8_t> surface_masks_;
  exec::Buffer<uint8_t> brick_states_;
  exec::Buffer<uint32_t> brick_last_seen_;
  exec::Buffer<DepthRange> tile_rows_, tiles_;
  exec::Buffer<uint8_t> selected_;
  exec::Buffer<int32_t> slots_;
  exec::Buffer<uint8_t> fused_columns_;
  BrickDistances brick_distances_;
  exec::Buffer<RayStretch> ray_stretches_;
  ModelView model_view_;
  SliceExtractor extractor_;
};

}  // namespace kt
