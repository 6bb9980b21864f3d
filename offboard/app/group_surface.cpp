// Deformation and re-integration of one group.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/app/group_surface.h"

#include <algorithm>
#include <map>
#include <utility>

#include "offboard/deformation/constraints.h"
#include "offboard/deformation/deform.h"
#include "offboard/deformation/solve_deformation.h"
#include "offboard/deformation/unify_sequences.h"
#include "offboard/map/sheets.h"
#include "offboard/map/stays.h"
#include "offboard/map/weld.h"
#include "shared/core/check.h"

namespace kt {
namespace {

constexpr const char* kOtherMission =
    "the frames are those of another mission: their time stamps or their depth are not what the log holds";

// So many more keyframes may be shown otherwise than as they are, before all are known.
constexpr int64_t kDoubtful = 3;

}  // namespace

Mesh surface_of_slices(Group& group, std::span<const LoopClosure> closures, int threads, bool* is_in_place) {
  std::vector<Mesh> patches;
  bool has_moved = group.segments.size() > 1;
  double voxel_size_m = 0;
  for (size_t s = 0; s < group.segments.size(); ++s) {
    Segment& segment = group.segments[s];
    DeformationGraph graph = build_deformation_graph(segment.trajectory, group.T_world_camera[s]);
    has_moved |= !graph.is_identity();
    if (!has_moved || segment.slices.empty()) continue;
    std::vector<PointConstraint> constraints =
        camera_constraints(segment.trajectory, group.T_world_camera[s], graph.config);
    for (const PointConstraint& one :
         surface_constraints(segment.trajectory, group.T_world_camera[s], closures))
      constraints.push_back(one);
    *is_in_place &= solve(graph, constraints).accepted;
    const auto stays = stays_of(segment.slices);  // where odometry has them
    unify_pose_sequences(segment.slices);
    for (CloudSlice& slice : segment.slices) deform(graph, slice.vertices, threads);
    for (Mesh& patch : weld_stays(segment.slices, stays)) patches.push_back(std::move(patch));
    voxel_size_m = segment.slices.front().voxel_size_m;
  }
  if (!has_moved) return weld(group.segments.front().slices);
  SheetConfig config = SheetConfig::of_voxels(voxel_size_m);
  config.threads = threads;
  return one_sheet(patches, config).mesh;
}

Mesh surface_of_frames(const Group& group, std::span<const MissionFrames> missions, const Session& session,
                       const exec::Device& device, const ReintegrationConfig& config,
                       const std::filesystem::path& scratch, const std::function<void(double)>& progress) {
  constexpr double kFusing = 0.9;  // of the work
  const Trajectory poses = group.trajectory();
  Reintegrator reintegrator(device, session.header.calibration, config, scratch);
  std::map<int64_t, const Keyframe*> keyframes;  // by sequence
  for (const Keyframe& keyframe : session.keyframes) keyframes.emplace(keyframe.sequence, &keyframe);
  int64_t count = 0, read = 0, fused = 0, shown = 0, not_shown = 0;
  for (const MissionFrames& mission : missions) count += std::max<int64_t>(1, mission.source->frame_count());
  for (const MissionFrames& mission : missions) {
    std::map<int64_t, const StampedPose*> by_stamp;
    for (const StampedPose& pose : poses) {
      const bool is_of_mission =
          pose.sequence >= mission.first_sequence && pose.sequence < mission.end_sequence;
      if (is_of_mission && pose.status == TrackingStatus::kGood) by_stamp.emplace(pose.timestamp_us, &pose);
    }
    if (by_stamp.empty()) continue;
    FrameSource& source = *mission.source;
    for (SourceItem item = source.next(); item.kind != SourceItem::Kind::kEnd; item = source.next()) {
      if (item.kind != SourceItem::Kind::kFrame) continue;
      const auto found = by_stamp.find(item.frame.timestamp_us);
      if (found != by_stamp.end()) {
        const StampedPose& pose = *found->second;
        item.frame.sequence = pose.sequence;
        reintegrator.fuse(item.frame, pose.T_odom_camera);
        ++fused;
        if (const auto keyframe = keyframes.find(pose.sequence); keyframe != keyframes.end())
          ++(reintegrator.shows(keyframe->second->depth) ? shown : not_shown);
        if (not_shown > shown + kDoubtful) throw Error(kOtherMission);
      }
      progress(kFusing * std::min(1.0, static_cast<double>(++read) / static_cast<double>(count)));
    }
  }
  if (fused == 0 || not_shown > shown) throw Error(kOtherMission);
  std::vector<CloudSlice> tiles;
  reintegrator.extract([&](CloudSlice tile) { tiles.push_back(std::move(tile)); },
                       [&](double share) { progress(kFusing + (1 - kFusing) * share); });
  return weld(tiles);
}

}  // namespace kt
