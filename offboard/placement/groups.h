// The pieces of a mission that stand in one frame each.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "offboard/placement/place_mission.h"
#include "offboard/session/segments.h"

namespace kt {

/// Segments that loop closures have joined, or a single one; never empty.
struct Group {
  std::vector<Segment> segments;                  ///< ascending by number, poses as logged
  std::vector<std::vector<Pose>> T_world_camera;  ///< where they stand: by segment, by pose

  int number() const { return segments.front().number; }
  int64_t good_frames() const;
  /// All poses in world, ascending by sequence.
  Trajectory trajectory() const;
};

/// Moves poses and slices out of `session` into groups, which ascend by number. A segment of which a damaged
/// log has lost all poses stands alone.
std::vector<Group> take_groups(Session& session, const PlacedMission& placed);

/// Index of the main one, as main_index(). Needs at least one.
size_t main_group(std::span<const Group> groups);

/// The graph of a group: its poses in world, and the edges between them that are believed.
PoseGraph graph_of(const Group& group, const PlacedMission& placed);

}  // namespace kt
