// The surface that a frame measured, kept so that later frames can be aligned with it as with the model.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "onboard/preprocess/frame_motion.h"
#include "onboard/preprocess/model_view.h"
#include "onboard/preprocess/preprocessor.h"
#include "shared/exec/block_pool.h"

namespace kt {

/// Its depth at the coarsest level, on the device, how its normals are made (SurfaceLevel), and how its
/// camera moved.
struct KeptSurface {
  exec::BlockPool<float>::Block depth;  ///< bordered
  int32_t normal_step = 1;
  float max_slope = 0;
  RowMotion shutter;
};

/// Memory for up to `capacity` surfaces at a time, allocated at once.
class SurfaceMemory {
 public:
  SurfaceMemory(const exec::Device& device, const Calibration& calibration, int64_t capacity);

  /// The surface of a frame; `motion` is that of its camera. Its memory serves again when it goes.
  KeptSurface keep(const FrameMaps& maps, const FrameMotion& motion);

 private:
  exec::Device device_;
  exec::BlockPool<float> depths_;
};

class FrameViews {
 public:
  FrameViews(const exec::Device& device, const Calibration& calibration);

  /// What a camera at T_odom_camera saw when `surface` was kept; stays valid until the next call.
  const ModelView& view(const KeptSurface& surface, const Pose& T_odom_camera);

 private:
  exec::Device device_;
  PinholeParams camera_;
  ModelView view_;
};

}  // namespace kt
