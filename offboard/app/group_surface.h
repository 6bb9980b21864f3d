// The surface of a group: bent from what the collector left, or fused anew.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <functional>

#include "offboard/placement/groups.h"
#include "offboard/reintegration/reintegrator.h"
#include "onboard/source/frame_source.h"
#include "shared/io/mesh.h"

namespace kt {

/// The group's slices in world, welded; moves their vertices there. Where no pose has changed, neither has
/// any vertex.
Mesh surface_of_slices(Group& group);

/// What all good frames of the group see, fused anew at the group's poses; `source` gives the frames, and may
/// give others. `scratch`: a file for voxels, removed in the end. Throws kt::Error where it gives none of
/// them.
Mesh surface_of_frames(const Group& group, FrameSource& source, const exec::Device& device,
                       const ReintegrationConfig& config, const std::filesystem::path& scratch,
                       const std::function<void(double)>& progress);

}  // namespace kt
