// Words for what a run has made.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/app/map_summary.h"

#include <algorithm>

#include "offboard/app/segment_folders.h"
#include "offboard/session/integrity_report.h"

namespace kt {
namespace {

std::string size_text(const MapMesh& map) {
  return std::to_string(map.mesh->vertices()) + " vertices, " + std::to_string(map.mesh->triangles()) +
         " triangles";
}

// A line for each where there are several.
std::string groups_text(std::span<const GroupMap> maps) {
  if (maps.size() == 1) return {};
  std::string text =
      std::to_string(maps.size()) + " segments, not joined: how they stand to each other is not known\n";
  for (const GroupMap& map : maps) {
    text += "  segment " + std::to_string(map.group.number()) + ": " +
            std::to_string(map.group.trajectory().size()) + " poses, " +
            std::to_string(map.group.good_frames()) + " good, " + size_text(map.map) + "; ";
    text += (map.folder.empty() ? "not written" : "in " + map.folder) + "\n";
  }
  return text;
}

std::string warning_text(std::span<const GroupMap> maps) {
  std::string text;
  for (const GroupMap& map : maps) {
    if (map.is_in_place) continue;
    text += "warning: segment " + std::to_string(map.group.number()) +
            " would tear if its surface were bent to the optimised poses: it stands where odometry has it; " +
            "--frames with the recording fuses it anew\n";
  }
  return text;
}

std::string listed(const std::string& list, const std::string& name) {
  return list.empty() ? name : list + ", " + name;
}

}  // namespace

std::string log_text(const Session& session) { return "log:  " + integrity_text(session.integrity) + "\n"; }

std::string candidates_text(std::span<const LoopClosure> candidates) {
  const auto proved = std::count_if(candidates.begin(), candidates.end(),
                                    [](const LoopClosure& loop) { return loop.accepted(); });
  return "loops: " + std::to_string(candidates.size()) + " places compared, " + std::to_string(proved) +
         " proved\n";
}

std::string placed_text(const PlacedMission& placed) {
  const std::vector<size_t>& loops = placed.measured.loop_edges;
  const auto believed = std::count_if(loops.begin(), loops.end(),
                                      [&](size_t edge) { return placed.solution.edges[edge].weight > 0; });
  return "graph: " + std::to_string(believed) + " of " + std::to_string(loops.size()) +
         " proved closures believed\n";
}

std::string refined_text(const Refinement& refinement) {
  std::string kept;
  for (const RefinementStep& step : refinement.steps) {
    if (step.is_kept) kept = listed(kept, step.name);
  }
  if (kept.empty()) return {};
  const std::string file = refinement.change.is_none() ? "" : std::string("; see ") + kCorrectedCalibration;
  return "refined by " + std::to_string(refinement.tracks) + " features: " + kept + file + "\n";
}

std::string map_text(std::span<const GroupMap> maps, size_t main, const MapOptions& options) {
  std::string names;
  for (const std::string& format : options.formats) names += map_file(format) + ", ";
  return "map:  " + size_text(maps[main].map) + " from " +
         (maps[main].surface == SurfaceSource::kFrames ? "all frames" : "the collector's slices") +
         "\npath: " + std::to_string(maps[main].group.trajectory().size()) + " poses\nwritten to " +
         options.output.string() + ": " + names + "trajectory.txt, poses.g2o, report.json\n" +
         groups_text(maps) + warning_text(maps);
}

std::string stages_text(const StageRunner& stages) {
  std::string taken, text;
  for (const StageDone& stage : stages.done()) {
    if (stage.is_from_file) taken = listed(taken, stage.name);
  }
  for (const std::string& note : stages.notes()) text += note + "\n";
  if (!taken.empty()) text += "taken from an earlier run: " + taken + "\n";
  return text;
}

std::string stopped_text(const StageRunner& stages, const StageStore& store) {
  std::string made;
  for (const StageDone& stage : stages.done()) made = listed(made, stage.name);
  return "stopped after " + stages.done().back().name + "; in " + store.folder().string() + ": " + made +
         "\n";
}

}  // namespace kt
