// The offboard pipeline: from a log to a map, on one screen.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "offboard/map/islands.h"
#include "offboard/map/simplify.h"
#include "offboard/placement/place_mission.h"
#include "offboard/stages/stage_runner.h"
#include "shared/exec/device.h"

namespace kt {

/// What the surface is made of.
enum class SurfaceChoice {
  kAuto,    ///< frames where there are any, else slices
  kSlices,  ///< the collector's cloud slices, bent to where the optimised poses are
  kFrames,  ///< all frames, fused anew at their optimised poses
};

/// In their order. All but the mesh are kept in files (StageStore): `load` an index of the logs, `loops`
/// all candidates, `optimise` the solved graph, `refine` the poses after bundle adjustment, the surface as
/// `deform` or `fuse`, whichever made it.
enum class MapStage { kLoad, kLoops, kOptimise, kRefine, kSurface, kMesh };

struct MapOptions {
  std::vector<std::filesystem::path> logs;  ///< one, or several of one camera, to be joined
  std::filesystem::path output;  ///< folder, made where it is missing; files of earlier runs are replaced
  LoopOptions loops{};
  PoseGraphOptions graph{};
  bool refines = true;  ///< poses and calibration by features, where that proves better
  SurfaceChoice surface = SurfaceChoice::kAuto;
  bool surface_constraints = false;  ///< bent slices heed the inlier points of loop closures too
  /// Where the frames come from, as open_source takes it, in the order of the logs; empty: the logs
  /// themselves.
  std::vector<std::string> frames{};
  IslandConfig islands{};                    ///< smaller pieces of the mesh are dropped
  std::optional<SimplifyConfig> simplify{};  ///< fewer triangles
  std::vector<std::string> formats{"ply"};   ///< of the map: ply, obj, glb, pcd
  double voxel_size_m = 0;                   ///< of the surface fused anew; 0: the collector's
  /// Whether frames that are fused anew are brought to one exposure, where that makes views agree better.
  bool even_exposure = true;
  bool keeps_stages = true;          ///< in output/stages; else all is made, and nothing is left
  std::optional<MapStage> from{};    ///< this stage and those behind it are made anew in any case
  MapStage until = MapStage::kMesh;  ///< the last one that is run
  exec::Device device = exec::Device::cpu();
  int threads = 0;  ///< of the CPU; 0: one per core
};

/// What refinement has found of the camera, to be given to its next mission as --calibration.
inline constexpr const char* kCorrectedCalibration = "corrected_calibration.yaml";

/// Joins the logs and writes map.ply (or another format), trajectory.txt and poses.g2o of the main group
/// (main_group) and report.json to options.output; what else has good frames or surface goes to folders
/// segment-N there, a calibration that refinement has changed to kCorrectedCalibration. What an earlier run
/// has kept of the same is taken from output/stages: the files are the same as without. Returns a summary of
/// a few lines for people. Throws kt::Error where the log is no mission, or the output cannot be written.
std::string make_map(const MapOptions& options, const StageProgress& progress = {});

}  // namespace kt
