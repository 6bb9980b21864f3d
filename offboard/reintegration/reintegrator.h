// Fuses frames anew, at poses known by now, into a volume of any extent.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <functional>

#include "offboard/reintegration/brick_store.h"
#include "onboard/fusion/tsdf_volume.h"
#include "onboard/preprocess/preprocessor.h"
#include "shared/types/calibration.h"
#include "shared/types/cloud_slice.h"
#include "shared/types/rgbd_frame.h"

namespace kt {

struct ReintegrationConfig {
  PreprocessConfig preprocess;
  VolumeConfig volume{.max_weight = 255};  ///< what is held in memory at a time
};

/// The collector's integrator in a volume that follows the camera; bricks that leave it wait in a file until
/// the camera comes back, with all that was known of their surface. Memory does not grow with the map but for
/// a list of its blocks of bricks, some 300 bytes each.
class Reintegrator {
 public:
  /// `scratch`: the file, some 6 kB for each cube of 8 voxels with surface; removed in the end. Throws
  /// kt::Error as the stages do.
  Reintegrator(const exec::Device& device, const Calibration& calibration, const ReintegrationConfig& config,
               const std::filesystem::path& scratch);

  /// Fuses a frame seen from T_world_camera by a camera that moves with `velocity`, in its own frame [rad/s;
  /// m/s].
  void fuse(const RgbdFrame& frame, const Pose& T_world_camera, const Vector6d& velocity = Vector6d::Zero());

  /// Whether the frame that was fused last shows the depth that a keyframe has kept of it (Keyframe::depth).
  bool shows(const Image<uint16_t>& keyframe_depth) const;

  /// The side of a tile in voxels: each is a cube of the grid, at multiples of it.
  int tile_side() const;

  /// Hands over the surface, tile by tile, ascending by z, y and x: slices in the world frame that weld
  /// without gap, each cell in the one of its tile, each at most once; is told the share done. Call once,
  /// after the last frame.
  void extract(const std::function<void(CloudSlice)>& take, const std::function<void(double)>& progress);

 private:
  VoxelBounds bounds_at(Vec3i origin_brick) const;
  CloudSlice tile_at(Vec3i low_brick);
  int owned_bricks() const;  // per axis, of a tile

  ReintegrationConfig config_;
  Preprocessor preprocessor_;
  TsdfVolume volume_;
  BrickStore store_;
  const FrameMaps* maps_ = nullptr;  // of the last frame
  int64_t last_us_ = 0;
};

}  // namespace kt
