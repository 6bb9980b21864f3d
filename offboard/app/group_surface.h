// The surface of a group in tiles: bent from what the collector left, or fused anew.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <span>

#include "offboard/map/tile_grid.h"
#include "offboard/placement/groups.h"
#include "offboard/reintegration/reintegrator.h"
#include "offboard/session/join_sessions.h"
#include "onboard/source/frame_source.h"

namespace kt {

struct SliceSurfaceConfig {
  /// Their inlier points bend the slices beside the poses; none: the poses alone do.
  std::span<const LoopClosure> closures{};
  TileGrid grid{};  ///< how much is held at a time; the surface does not depend on it
  int threads = 0;  ///< 0 = one per core; nor on these
};

/// The group's slices bent to where its poses are, places seen twice in one sheet, read from `logs`. A single
/// segment none of whose poses has changed is welded as it is. `tiles`: the file (TileFile) that is written;
/// others stand beside it meanwhile. Throws kt::Error where a log cannot be read or a file not be written.
///
/// `is_in_place` becomes false where the bend of a segment was refused, for it would have torn the surface.
void surface_of_slices(const Group& group, std::span<const MissionLog> logs, const SliceSurfaceConfig& config,
                       const std::filesystem::path& tiles, const std::function<void(double)>& progress,
                       bool* is_in_place);

/// Where the frames of a mission come from, and which sequences the session gave them.
struct MissionFrames {
  std::unique_ptr<FrameSource> source;
  int64_t first_sequence = 0, end_sequence = 0;
};

/// What all good frames of the group see, fused anew at the group's poses; the sources may give other frames
/// too. `session`: for the calibration, and the keyframes. `tiles`: the file (TileFile) that is written; one
/// for voxels stands beside it meanwhile. Throws kt::Error where the frames are those of another mission:
/// none has the stamp of a good pose, or keyframes show something else.
void surface_of_frames(const Group& group, std::span<const MissionFrames> missions, const Session& session,
                       const exec::Device& device, const ReintegrationConfig& config,
                       const std::filesystem::path& tiles, const std::function<void(double)>& progress);

}  // namespace kt
