// Exports what leaves the volume as a cloud slice.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "onboard/fusion/slice_kernel.h"
#include "shared/exec/buffer.h"
#include "shared/types/cloud_slice.h"

namespace kt {

class SliceExtractor {
 public:
  /// `brick_count`: of the volume.
  SliceExtractor(const exec::Device& device, int64_t brick_count);

  /// Vertices and triangles of the cells that the rule exports; freezes what they share with the rest and
  /// clears the bricks outside rule.after. Pose, stamp and sequence of the slice are the caller's to fill in.
  CloudSlice extract(const ExportRule& rule);

 private:
  exec::Device device_;
  exec::Buffer<MarchingCubesTable> table_;
  exec::Buffer<uint8_t> selected_;
  exec::Buffer<int32_t> slots_;
};

}  // namespace kt
