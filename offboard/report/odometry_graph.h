// A session as a pose graph.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "shared/io/g2o.h"
#include "shared/types/session.h"

namespace kt {

/// One node per pose (its id is the frame's sequence, the first is fixed), one edge to each pose from the
/// one it was measured against (the one before, where the log has lost that) with the information that the
/// collector gave it, and one for each accepted loop closure between poses that are there.
PoseGraph odometry_graph(const Session& session);

}  // namespace kt
