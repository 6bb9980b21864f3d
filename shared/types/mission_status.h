// The collector's running counts, for whoever watches it and for the report.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>

#include "shared/core/vec.h"
#include "shared/types/stamped_pose.h"
#include "shared/types/storage_state.h"

namespace kt {

/// What is logged depends neither on the clock nor on the machine, so that equal missions give equal logs
/// where the disk has room for them.
struct MissionStatus {
  int64_t sequence = 0;      ///< counts status messages
  int64_t timestamp_us = 0;  ///< of the last frame
  int64_t frames = 0;        ///< processed
  int64_t frames_good = 0, frames_uncertain = 0, frames_lost = 0;
  int64_t frames_skipped = 0;  ///< unreadable, lost, out of order, of the wrong size, without valid depth, or
                               ///< dropped: too many waited
  std::array<int64_t, kPoseSources> frames_by_source{};  ///< processed, by PoseSource
  int64_t slices = 0, slice_vertices = 0, slice_triangles = 0;
  Vec3i volume_origin_voxel;  ///< lowest voxel of the volume in the odom grid
  int segment = 0;            ///< the one that the camera is in
  int segments = 0;           ///< begun so far
  // Of the last frame:
  TrackingStatus tracking = TrackingStatus::kGood;
  PoseSource source = PoseSource::kNone;
  TrackingCause cause = TrackingCause::kNone;
  double inlier_share = 0;
  /// Of the hottest part of the computer, where results are published live; 0: not told, as in every log.
  int temperature_c = 0;
  /// Messages that did not go out to who listens, before this one; 0 in every log, as above.
  int64_t not_published = 0;
  // Of the log, before this message:
  StorageLevel storage = StorageLevel::kAll;
  int64_t not_stored = 0;  ///< messages, for want of room
};

}  // namespace kt
