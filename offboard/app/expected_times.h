// What the stages of a mission usually take.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "offboard/report/map_report.h"
#include "offboard/stages/time_to_go.h"
#include "shared/types/session.h"

namespace kt {

/// Adds all stages behind `load` to `time_to_go`, by the size of the mission and rates measured once.
void expect_stages(const Session& session, SurfaceSource source, TimeToGo& time_to_go);

}  // namespace kt
