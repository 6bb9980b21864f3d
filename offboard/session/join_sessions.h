// Several missions as one.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <functional>
#include <span>
#include <vector>

#include "shared/types/session.h"

namespace kt {

/// What is added to the numbers of a mission, so that nothing of one is taken for something of another.
struct Renumbering {
  int64_t sequence = 0, slice = 0, loop = 0;
  int segment = 0;
};

struct JoinedSession {
  Session session;
  std::vector<Renumbering> missions;  ///< of each, in their order
};

/// Frames, segments, slices and closures are numbered on from mission to mission; counts of the logs'
/// integrity are added up. The header is the first one's. Throws kt::Error where cameras or voxel sizes
/// differ. Needs at least one; a single one stays as it is.
JoinedSession join_sessions(std::vector<Session> sessions);

/// The log of a mission, and how it is numbered among others.
struct MissionLog {
  std::filesystem::path path;
  Renumbering numbers;
};

/// Reads the slices of missions, in order, numbered as in the JoinedSession: one after the other, so that few
/// are in memory. Throws kt::Error where a log cannot be read; what is damaged is passed over, as
/// load_session does.
void load_slices(std::span<const MissionLog> logs, const std::function<void(CloudSlice&&)>& take);

}  // namespace kt
