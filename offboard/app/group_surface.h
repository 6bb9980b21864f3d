// The surface of a group in tiles: bent from what the collector left, or fused anew.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <functional>
#include <span>

#include "offboard/app/placed_frames.h"
#include "offboard/exposure/frame_gains.h"
#include "offboard/map/tile_grid.h"
#include "offboard/placement/groups.h"
#include "offboard/reintegration/reintegrator.h"
#include "offboard/session/join_sessions.h"

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

/// How the frames of the group were exposed. Reads the sources to their end.
FrameGains gains_of_frames(const Group& group, std::span<const MissionFrames> missions,
                           const Session& session, const exec::Device& device, const PreprocessConfig& config,
                           const std::function<void(double)>& progress);

/// What all good frames of the group see, fused anew at the group's poses with their colours as `gains` has
/// them; the sources may give other frames too. `session`: for the calibration, and the keyframes. `tiles`:
/// the file (TileFile) that is written; one for voxels stands beside it meanwhile. Throws kt::Error where the
/// frames are those of another mission: none has the stamp of a good pose, or keyframes show something else.
void surface_of_frames(const Group& group, std::span<const MissionFrames> missions, const Session& session,
                       const FrameGains& gains, const exec::Device& device, const ReintegrationConfig& config,
                       const std::filesystem::path& tiles, const std::function<void(double)>& progress);

}  // namespace kt
