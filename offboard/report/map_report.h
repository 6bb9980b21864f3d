// report.json: what a mission held and what became of it.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "offboard/exposure/frame_gains.h"
#include "offboard/map/mesh_of_tiles.h"
#include "offboard/placement/groups.h"
#include "offboard/refinement/refine.h"
#include "offboard/stages/stage_runner.h"
#include "shared/types/session.h"

namespace kt {

/// What depends on machine and moment.
struct RunFigures {
  std::vector<std::string> logs;  ///< paths as given
  std::vector<StageDone> stages;  ///< in their order
  int64_t peak_memory_bytes = 0;
};

/// What the surface of a group was made of.
enum class SurfaceSource {
  kSlices,  ///< the collector's, bent to where the poses are
  kFrames,  ///< all frames, fused anew
};

/// A group of segments, the map made of it, and where that stands.
struct GroupMap {
  Group group;
  MapMesh map;
  SurfaceSource surface = SurfaceSource::kSlices;
  /// False where bending the slices to the poses would have torn them: a segment's stand where odometry has
  /// them.
  bool is_in_place = true;
  std::string folder;  ///< within the output folder: "." for the main group; "" where nothing is written
  ExposureFigures exposure{};  ///< of frames fused anew
};

/// A file of the map, as it was written.
struct MapFile {
  std::string name;  ///< within the output folder
  int64_t bytes = 0;
  std::string digest;  ///< of its content
};

/// Metres from pose to pose.
double path_length_m(const Trajectory& trajectory);

/// JSON text. "trajectory" and "map" are of groups[main], "segments" lists all, the rest is of the whole
/// mission: `session` without its poses and slices, which the groups hold. All but "run" is the same for
/// every run over the same log.
std::string map_report(const Session& session, const PlacedMission& placed, const Refinement& refinement,
                       std::span<const GroupMap> groups, size_t main, std::span<const MapFile> files,
                       const RunFigures& run);

}  // namespace kt
