// The offboard pipeline: from a log to a map, on one screen.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "offboard/map/islands.h"
#include "offboard/map/simplify.h"
#include "offboard/placement/place_mission.h"
#include "shared/exec/device.h"

namespace kt {

/// Is told what happens: the name of a step, and its share done in [0, 1].
using StepProgress = std::function<void(const std::string& step, double share)>;

/// What the surface is made of.
enum class SurfaceChoice {
  kAuto,    ///< frames where there are any, else slices
  kSlices,  ///< the collector's cloud slices, bent to where the optimised poses are
  kFrames,  ///< all frames, fused anew at their optimised poses
};

struct MapOptions {
  std::vector<std::filesystem::path> logs;  ///< one, or several of one camera, to be joined
  std::filesystem::path output;  ///< folder, made where it is missing; files of earlier runs are replaced
  PlacementConfig placement{};
  SurfaceChoice surface = SurfaceChoice::kAuto;
  /// Where the frames come from, as open_source takes it, in the order of the logs; empty: the logs
  /// themselves.
  std::vector<std::string> frames{};
  IslandConfig islands{};                    ///< smaller pieces of the mesh are dropped
  std::optional<SimplifyConfig> simplify{};  ///< fewer triangles
  std::vector<std::string> formats{"ply"};   ///< of the map: ply, obj, glb, pcd
  /// Whether frames that are fused anew are brought to one exposure, where that makes views agree better.
  bool even_exposure = true;
  double voxel_size_m = 0;  ///< of the surface fused anew; 0: the collector's
  exec::Device device = exec::Device::cpu();
};

/// Joins the logs and writes map.ply (or another format), trajectory.txt and poses.g2o of the main group
/// (main_group) and report.json to options.output; what else has good frames or surface goes to folders
/// segment-N there. Returns a summary of a few lines for people. Throws kt::Error where the log is no
/// mission, or the output cannot be written.
std::string make_map(const MapOptions& options, const StepProgress& progress = {});

}  // namespace kt
