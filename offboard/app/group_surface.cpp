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
#include "offboard/exposure/exposure_estimator.h"
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

Mesh surface_of_slices(Group& group, int threads, bool* is_in_place) {
  std::vector<Mesh> patches;
  bool has_moved = group.segments.size() > 1;
  double voxel_size_m = 0;
  for (size_t s = 0; s < group.segments.size(); ++s) {
    Segment& segment = group.segments[s];
    DeformationGraph graph = build_deformation_graph(segment.trajectory, group.T_world_camera[s]);
    has_moved |= !graph.is_identity();
    if (!has_moved || segment.slices.empty()) continue;
    *is_in_place &=
        solve(graph, camera_constraints(segment.trajectory, group.T_world_camera[s], graph.config)).accepted;
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

FrameGains gains_of_frames(const Group& group, std::span<const MissionFrames> missions,
                           const Session& session, const exec::Device& device, const PreprocessConfig& config,
                           const std::function<void(double)>& progress) {
  ExposureEstimator estimator(device, session.header.calibration, config);
  for_each_placed_frame(
      group, missions,
      [&](const RgbdFrame& frame, const StampedPose& pose) { estimator.add(frame, pose.T_odom_camera); },
      progress);
  return estimator.finish();
}

Mesh surface_of_frames(const Group& group, std::span<const MissionFrames> missions, const Session& session,
                       const FrameGains& gains, const exec::Device& device, const ReintegrationConfig& config,
                       const std::filesystem::path& scratch, const std::function<void(double)>& progress) {
  constexpr double kFusing = 0.9;  // of the work
  Reintegrator reintegrator(device, session.header.calibration, config, scratch);
  std::map<int64_t, const Keyframe*> keyframes;  // by sequence
  for (const Keyframe& keyframe : session.keyframes) keyframes.emplace(keyframe.sequence, &keyframe);
  int64_t fused = 0, shown = 0, not_shown = 0;
  const auto fuse = [&](const RgbdFrame& frame, const StampedPose& pose) {
    reintegrator.fuse(frame, pose.T_odom_camera, gains.factor(pose.sequence));
    ++fused;
    if (const auto keyframe = keyframes.find(pose.sequence); keyframe != keyframes.end())
      ++(reintegrator.shows(keyframe->second->depth) ? shown : not_shown);
    if (not_shown > shown + kDoubtful) throw Error(kOtherMission);
  };
  for_each_placed_frame(group, missions, fuse, [&](double share) { progress(kFusing * share); });
  if (fused == 0 || not_shown > shown) throw Error(kOtherMission);
  std::vector<CloudSlice> tiles;
  reintegrator.extract([&](CloudSlice tile) { tiles.push_back(std::move(tile)); },
                       [&](double share) { progress(kFusing + (1 - kFusing) * share); });
  return weld(tiles);
}

}  // namespace kt
