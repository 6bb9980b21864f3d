// A mission's segments, each with its own poses and slices.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "shared/types/session.h"

namespace kt {

/// A stretch of the mission with an odom frame of its own. Nothing is known of how segments stand to each
/// other; that slices of different ones share an EdgeKey means nothing.
struct Segment {
  int number = 0;                 ///< as StampedPose::segment
  Trajectory trajectory;          ///< in order; empty where a damaged log has lost it
  std::vector<SliceInfo> slices;  ///< in order

  int64_t good_frames() const;
};

/// Moves the poses and slices out of `session` into its segments, which ascend by number. Numbers need not
/// ascend along the mission: the camera may come back into an earlier segment.
std::vector<Segment> take_segments(Session& session);

/// What the main one of several segments, or groups of them, has most of: good frames, else poses at all.
struct Importance {
  int64_t good_frames = 0;
  bool has_poses = false;
  friend auto operator<=>(const Importance&, const Importance&) = default;
};
Importance importance_of(const Segment& segment);

/// Index of the greatest, the earliest of equals. Needs at least one.
size_t main_index(std::span<const Importance> importances);
size_t main_segment(std::span<const Segment> segments);

}  // namespace kt
