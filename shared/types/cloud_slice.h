// The surface that left the moving volume, as an indexed mesh patch.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "shared/geometry/se3.h"
#include "shared/types/slice_vertex.h"

namespace kt {

struct CloudSlice {
  int64_t sequence = 0;                   ///< counts the slices of a log, from 0; parts of one share it
  int segment = 0;                        ///< as StampedPose::segment
  int64_t timestamp_us = 0;               ///< of the frame at which it left the volume
  Pose T_odom_camera = Pose::Identity();  ///< camera pose at that frame
  double voxel_size_m = 0;
  bool is_final = false;  ///< the flush of the whole volume at the end of a mission, or its last part
  std::vector<SliceVertex> vertices;  ///< sorted by key, each key once
  std::vector<std::array<uint32_t, 3>>
      triangles;  ///< indices into `vertices`, counter-clockwise seen from outside
};

/// The triangles of `slice` with these numbers, in this order, and the vertices that they use. Never final.
CloudSlice part_of(const CloudSlice& slice, std::span<const uint32_t> triangles);

/// `slice` in parts of at most `max_triangles` triangles and `max_vertices` vertices (3 or more), which weld
/// to the same surface: vertices of triangles in several parts stand in each. Only the last part is final.
/// Vertices that no triangle uses are left out; a slice without triangles gives one part without vertices.
std::vector<CloudSlice> split_slice(const CloudSlice& slice, size_t max_triangles,
                                    size_t max_vertices = SIZE_MAX);

}  // namespace kt
