// The frame whose image later frames are compared with: points of the model surface, and how bright it was
// there.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>

#include "onboard/preprocess/frame_motion.h"
#include "onboard/preprocess/model_view.h"
#include "onboard/preprocess/preprocessor.h"
#include "onboard/tracking/photometric_kernel.h"

namespace kt {

class PhotometricReference {
 public:
  /// For model views of `model_pixels` pixels.
  PhotometricReference(const exec::Device& device, const Calibration& calibration, int64_t model_pixels);

  /// Takes a fused frame and the model view predicted from its pose; `motion` is that of its camera.
  void take(const FrameMaps& maps, const ModelView& model, const FrameMotion& motion = {});

  /// As if nothing had been taken.
  void forget() { counts_ = {}; }

  /// Where there is none yet, or its frame had no texture or colour, no point.
  int64_t point_count(int level) const { return counts_[static_cast<size_t>(level)]; }
  bool is_empty() const { return counts_[0] == 0; }
  const Pose& T_odom_reference() const { return T_odom_reference_; }

  /// Residuals of a frame at intensity level `level`, for the model view whose camera stands at T_odom_model;
  /// `sigma` is their expected size (grey levels), `motion` as for take.
  PhotometricResidual residual(const FrameMaps& maps, int level, const Pose& T_odom_model,
                               const Pose& T_model_current, const Exposure& exposure, float sigma,
                               const FrameMotion& motion = {}) const;

 private:
  exec::Device device_;
  Pose T_colour_depth_;
  Pose T_odom_reference_ = Pose::Identity();
  exec::Buffer<Vec4f> candidates_;
  exec::Buffer<uint8_t> picked_;
  exec::Buffer<int32_t> indices_;
  std::array<exec::Buffer<Vec4f>, 2> points_;  // levels 0 and 1: half and a quarter of the resolution
  std::array<int64_t, 2> counts_{};
};

}  // namespace kt
