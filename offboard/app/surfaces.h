// The surfaces of all groups of a mission, as the stage `deform` or `fuse` leaves them.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <functional>
#include <span>
#include <vector>

#include "offboard/app/make_map.h"
#include "offboard/placement/groups.h"
#include "offboard/reintegration/reintegrator.h"
#include "offboard/report/map_report.h"
#include "offboard/session/join_sessions.h"
#include "offboard/session/load_session.h"

namespace kt {

/// What is known of a surface beside its file of tiles.
struct GroupSurface {
  SurfaceSource source = SurfaceSource::kSlices;
  bool is_in_place = true;  ///< as GroupMap::is_in_place
  ExposureFigures exposure{};
};

/// What options.surface comes to with these logs. Throws kt::Error where it asks for frames that are not
/// there.
SurfaceSource surface_source(const MapOptions& options, const Session& session,
                             std::span<const LogIndex> indices);

/// What frames are fused with: the collector's limits, and options.voxel_size_m or else its voxels.
ReintegrationConfig fusion_of(const MapOptions& options, const Session& session);

/// By group; a group without good frames has its slices either way. `joined`: without the poses and slices
/// that `groups` have taken. `closures`: whose points bend slices too. `tiles(group)`: the TileFile to write.
std::vector<GroupSurface> make_surfaces(SurfaceSource source, const ReintegrationConfig& fusion,
                                        std::span<const Group> groups, const JoinedSession& joined,
                                        std::span<const LoopClosure> closures, const MapOptions& options,
                                        const std::function<std::filesystem::path(const Group&)>& tiles,
                                        const TellShare& tell);

}  // namespace kt
