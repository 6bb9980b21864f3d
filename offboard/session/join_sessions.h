// Several missions as one.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "shared/types/session.h"

namespace kt {

struct JoinedSession {
  Session session;
  /// Of each mission: what was added to the sequences of its frames.
  std::vector<int64_t> first_sequences;
};

/// Frames, segments, slices and closures are numbered on from mission to mission, so that nothing of one is
/// taken for something of another; counts of the logs' integrity are added up. The header is the first one's.
/// Throws kt::Error where cameras or voxel sizes differ. Needs at least one; a single one stays as it is.
JoinedSession join_sessions(std::vector<Session> sessions);

}  // namespace kt
