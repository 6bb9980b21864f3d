// Deformation of one group: the slices in tiles, what is welded of them, what of that is one sheet.
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <map>
#include <utility>
#include <vector>

#include "offboard/app/group_surface.h"
#include "offboard/deformation/constraints.h"
#include "offboard/deformation/deform.h"
#include "offboard/deformation/solve_deformation.h"
#include "offboard/deformation/unify_sequences.h"
#include "offboard/map/sheets.h"
#include "offboard/map/slice_tiles.h"
#include "offboard/map/splinters.h"
#include "offboard/map/stays.h"
#include "offboard/map/tile_file.h"
#include "offboard/map/weld.h"

namespace kt {
namespace {

// A triangle depends on what is so many cells around it: once for welding, once for the sheet; and on the
// copies of its vertices, which lie on edges of its cell.
constexpr int32_t kMargin = 2 * kSplinterReach + 1;

// What is known of a segment's slices before they are deformed.
struct SegmentSlices {
  DeformationGraph graph;
  SliceWeights weights;
  std::vector<int64_t> sequences;       // ascending
  std::map<int64_t, int32_t> patch_of;  // by sequence: of the whole group
};

// The graphs of all segments; false where nothing moves.
bool solve_graphs(const Group& group, std::vector<SegmentSlices>& segments, bool* is_in_place) {
  bool has_moved = group.segments.size() > 1;
  for (size_t s = 0; s < group.segments.size(); ++s) {
    const Segment& segment = group.segments[s];
    DeformationGraph& graph = segments[s].graph;
    graph = build_deformation_graph(segment.trajectory, group.T_world_camera[s]);
    has_moved |= !graph.is_identity();
    if (!has_moved || segment.slices.empty()) continue;
    *is_in_place &=
        solve(graph, camera_constraints(segment.trajectory, group.T_world_camera[s], graph.config)).accepted;
  }
  return has_moved;
}

void read_slices(const Group& group, std::span<const MissionLog> logs, std::vector<SegmentSlices>& segments,
                 SliceTiles& tiles) {
  std::map<int, size_t> place;  // by number
  for (const Segment& segment : group.segments) place.emplace(segment.number, place.size());
  load_slices(logs, [&](const CloudSlice& slice) {
    const auto found = place.find(slice.segment);
    if (found == place.end()) return;
    SegmentSlices& segment = segments[found->second];
    segment.weights.add(slice);
    if (segment.sequences.empty() || segment.sequences.back() != slice.sequence)
      segment.sequences.push_back(slice.sequence);
    tiles.add(static_cast<int32_t>(found->second), slice);
  });
}

// Stays become the patches of the group, numbered on from segment to segment.
void find_stays(const SliceTiles& tiles, const TileGrid& grid, std::vector<SegmentSlices>& segments) {
  std::vector<StayFinder> finders(segments.size());
  for (const TileId& id : tiles.tiles()) {
    const auto is_whole = [&](EdgeKey key) { return grid.is_within(id, key, kMargin); };
    finders[static_cast<size_t>(id.patch)].add(tiles.read(id), is_whole);
  }
  int32_t first = 0, end = 0;
  for (size_t s = 0; s < segments.size(); ++s, first = end) {
    segments[s].patch_of = finders[s].stays(segments[s].sequences);
    for (auto& [sequence, patch] : segments[s].patch_of) end = std::max(end, (patch += first) + 1);
  }
}

// What the slices of each patch hold of a tile, deformed and welded, with the margin that one_sheet() asks
// for.
void weld_tile(const SliceTiles& tiles, const TileId& id, const SliceSurfaceConfig& config,
               const SegmentSlices& segment, TileWriter& welded) {
  std::vector<CloudSlice> parts = tiles.read(id);
  if (!segment.graph.is_identity()) {
    unify_pose_sequences(parts);
    for (CloudSlice& part : parts) deform(segment.graph, part.vertices, config.threads);
  }
  for (size_t begin = 0, end = 0; begin < parts.size(); begin = end) {
    const int32_t patch = segment.patch_of.at(parts[begin].sequence);
    while (end < parts.size() && segment.patch_of.at(parts[end].sequence) == patch) ++end;
    MeshTile tile{{patch, id.z, id.y, id.x},
                  weld(std::span(parts).subspan(begin, end - begin), segment.weights)};
    std::vector<bool> is_within;
    for (size_t t = 0; t < tile.mesh.triangles.size(); ++t)
      is_within.push_back(config.grid.is_within(tile.id, cell_of(tile.mesh, t), kSplinterReach));
    keep_triangles(is_within, tile.mesh);
    welded.add(tile);
  }
}

}  // namespace

void surface_of_slices(const Group& group, std::span<const MissionLog> logs, const SliceSurfaceConfig& config,
                       const std::filesystem::path& tiles, const std::function<void(double)>& progress,
                       bool* is_in_place) {
  constexpr double kReading = 0.2, kWelding = 0.7;  // of the work
  std::vector<SegmentSlices> segments(group.segments.size());
  const bool has_moved = solve_graphs(group, segments, is_in_place);
  double voxel_size_m = 0;
  for (const Segment& segment : group.segments) {
    if (!segment.slices.empty()) voxel_size_m = segment.slices.front().voxel_size_m;
  }
  const std::filesystem::path patches = tiles.string() + ".patches";
  {
    SliceTiles slices(config.grid, kMargin, tiles.string() + ".slices");
    read_slices(group, logs, segments, slices);
    if (has_moved) {
      find_stays(slices, config.grid, segments);
    } else {
      for (const int64_t sequence : segments.front().sequences)
        segments.front().patch_of.emplace(sequence, 0);
    }
    progress(kReading);
    TileWriter welded(patches, config.grid);
    const std::vector<TileId> ids = slices.tiles();
    for (size_t i = 0; i < ids.size(); ++i) {
      weld_tile(slices, ids[i], config, segments[static_cast<size_t>(ids[i].patch)], welded);
      progress(kReading +
               (kWelding - kReading) * static_cast<double>(i + 1) / static_cast<double>(ids.size()));
    }
    welded.finish();
  }
  SheetConfig one = SheetConfig::of_voxels(voxel_size_m);
  one.threads = config.threads;
  TileWriter sheet(tiles, config.grid);
  one_sheet(TileFile(patches), one, tiles.string() + ".marks", sheet);
  sheet.finish();
  std::filesystem::remove(patches);
}

}  // namespace kt
