// What came of a run, in a few lines for people.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <string>

#include "offboard/app/make_map.h"
#include "offboard/report/map_report.h"

namespace kt {

/// "log:  1530 events, no damage\n"
std::string log_text(const Session& session);
/// "loops: 744 places compared, 181 proved\n"
std::string candidates_text(std::span<const LoopClosure> candidates);
/// "graph: 181 closures believed, 0 not\n"
std::string placed_text(const PlacedMission& placed);
/// "refined by 6992 features: poses\n", what of the calibration was changed, and where that stands; nothing
/// where nothing was.
std::string refined_text(const Refinement& refinement);
/// Size and source of the main map, where everything lies, and what is not as it should be.
std::string map_text(std::span<const GroupMap> maps, size_t main, const MapOptions& options);
/// Which stages were taken from files of an earlier run, and which of these were damaged; often nothing.
std::string stages_text(const StageRunner& stages);
/// That the run ended early, as asked for, and what it has left.
std::string stopped_text(const StageRunner& stages, const StageStore& store);

}  // namespace kt
