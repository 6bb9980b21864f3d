// Counts the bytes that integrating and predicting one frame cannot do without.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "onboard/fusion/tsdf_volume.h"
#include "onboard/preprocess/preprocessor.h"
#include "tools/bench/bench_kernel.h"

namespace kt::bench {

/// What the result of one frame proves to have moved between memory and processor, whatever the kernels are:
/// a lower bound, so that bytes / time against the measured bandwidth tells how much could be won at most.
/// The unit is a row of 8 voxels: 32 bytes, the least that a GPU reads.
struct FrameTraffic {
  int64_t voxel_rows = 0;    ///< that integrate changed: read and written, 32 bytes each
  int64_t colour_rows = 0;   ///< the same of the colours, 64 bytes each
  int64_t surface_rows = 0;  ///< different rows that hold the 8 voxels around a point of the prediction: read
  int64_t integrate_bytes = 0;  ///< the changed rows twice, and each fusion pixel once
  int64_t raycast_bytes = 0;    ///< the surface's rows, each brick's state, and each point and normal
};

/// Watches one frame: start() before integrate(), finish() after raycast() from the same pose.
class TrafficCount {
 public:
  TrafficCount(const exec::Device& device, const TsdfVolume& volume);
  void start(const TsdfVolume& volume);
  FrameTraffic finish(const TsdfVolume& volume, const FrameMaps& maps, const ModelView& model);

 private:
  exec::Device device_;
  int64_t bricks_;
  exec::Buffer<RowContent> rows_;
  exec::Buffer<int32_t> voxel_rows_, colour_rows_, offsets_;  // by brick
};

}  // namespace kt::bench
