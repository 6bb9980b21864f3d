// The offboard pipeline: from a log to a map, on one screen.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <functional>
#include <string>

namespace kt {

struct MapOptions {
  std::filesystem::path log;
  std::filesystem::path output;  ///< folder, made where it is missing; files of earlier runs are replaced
};

/// Is told what happens: the name of a step, and its share done in [0, 1].
using StepProgress = std::function<void(const std::string& step, double share)>;

/// Writes map.ply, trajectory.txt and poses.g2o of the main segment (main_segment) and report.json to
/// options.output; what else has good frames or surface goes to folders segment-N there. Returns a summary of
/// a few lines for people. Throws kt::Error where the log is no mission, or the output cannot be written.
std::string make_map(const MapOptions& options, const StepProgress& progress = {});

}  // namespace kt
