// A frame at low resolution, as frames are compared by their brightness.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <vector>

#include "offboard/exposure/channel_values.h"
#include "onboard/preprocess/preprocessor.h"
#include "shared/core/pinhole.h"
#include "shared/geometry/se3.h"

namespace kt {

/// A square of pixels on one surface.
struct ExposureCell {
  static constexpr float kUnusable = -1;

  float depth_m = 0;  ///< of its middle; 0: no surface, or one seen too obliquely
  /// Natural logarithm of the mean level; kUnusable where a pixel is clipped, or all are too dark.
  std::array<float, kColourChannels> log_levels{kUnusable, kUnusable, kUnusable};
};

struct ExposureView {
  Pose T_world_camera = Pose::Identity();
  PinholeParams camera;             ///< depth camera whose pixels are the cells
  std::vector<ExposureCell> cells;  ///< row by row

  const ExposureCell& at(int u, int v) const { return cells[static_cast<size_t>(v * camera.width + u)]; }
};

/// Some 80 x 60 cells of a frame with colour.
ExposureView make_exposure_view(const FrameMaps& maps, const Pose& T_world_camera);

/// What `b` shows of the cells of `a`: for each channel log(level in b) - log(level in a), cell by cell, of
/// those that both see unhidden and can use.
using LogRatios = std::array<std::vector<float>, kColourChannels>;
LogRatios log_ratios(const ExposureView& a, const ExposureView& b);

/// Share of the cells of `a` that have a surface which `b` sees too; by every `stride`-th cell either way.
double overlap(const ExposureView& a, const ExposureView& b, int stride);

}  // namespace kt
