// The surface of a group: bent from what the collector left, or fused anew.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <span>

#include "offboard/placement/groups.h"
#include "offboard/reintegration/reintegrator.h"
#include "onboard/source/frame_source.h"
#include "shared/io/mesh.h"

namespace kt {

/// The group's slices bent to where its poses are, places seen twice in one sheet; moves their vertices
/// there. A single segment none of whose poses has changed is welded as it is. The inliers of `closures`,
/// those believed, count as surface constraints; none: poses alone bend it.
///
/// `is_in_place` becomes false where the bend of a segment was refused, for it would have torn the surface.
Mesh surface_of_slices(Group& group, std::span<const LoopClosure> closures, int threads, bool* is_in_place);

/// Where the frames of a mission come from, and which sequences the session gave them.
struct MissionFrames {
  std::unique_ptr<FrameSource> source;
  int64_t first_sequence = 0, end_sequence = 0;
};

/// What all good frames of the group see, fused anew at the group's poses; the sources may give other frames
/// too. `session`: for the calibration, and the keyframes. `scratch`: a file for voxels, removed in the end.
/// Throws kt::Error where the frames are those of another mission: none has the stamp of a good pose, or
/// keyframes show something else.
Mesh surface_of_frames(const Group& group, std::span<const MissionFrames> missions, const Session& session,
                       const exec::Device& device, const ReintegrationConfig& config,
                       const std::filesystem::path& scratch, const std::function<void(double)>& progress);

}  // namespace kt
