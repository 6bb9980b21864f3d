// Re-integration of one group.
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <map>
#include <utility>

#include "offboard/app/group_surface.h"
#include "offboard/map/tile_file.h"
#include "offboard/map/weld.h"
#include "shared/core/check.h"

namespace kt {
namespace {

constexpr const char* kOtherMission =
    "the frames are those of another mission: their time stamps or their depth are not what the log holds";

// So many more keyframes may be shown otherwise than as they are, before all are known.
constexpr int64_t kDoubtful = 3;

}  // namespace

void surface_of_frames(const Group& group, std::span<const MissionFrames> missions, const Session& session,
                       const exec::Device& device, const ReintegrationConfig& config,
                       const std::filesystem::path& tiles, const std::function<void(double)>& progress) {
  constexpr double kFusing = 0.9;  // of the work
  const Trajectory poses = group.trajectory();
  const std::vector<Vector6d> motion = velocities(poses);
  Reintegrator reintegrator(device, session.header.calibration, config, tiles.string() + ".bricks");
  std::map<int64_t, const Keyframe*> keyframes;  // by sequence
  for (const Keyframe& keyframe : session.keyframes) keyframes.emplace(keyframe.sequence, &keyframe);
  int64_t count = 0, read = 0, fused = 0, shown = 0, not_shown = 0;
  for (const MissionFrames& mission : missions) count += std::max<int64_t>(1, mission.source->frame_count());
  for (const MissionFrames& mission : missions) {
    std::map<int64_t, size_t> by_stamp;
    for (size_t i = 0; i < poses.size(); ++i) {
      const StampedPose& pose = poses[i];
      const bool is_of_mission =
          pose.sequence >= mission.first_sequence && pose.sequence < mission.end_sequence;
      if (is_of_mission && pose.status == TrackingStatus::kGood) by_stamp.emplace(pose.timestamp_us, i);
    }
    if (by_stamp.empty()) continue;
    FrameSource& source = *mission.source;
    for (SourceItem item = source.next(); item.kind != SourceItem::Kind::kEnd; item = source.next()) {
      if (item.kind != SourceItem::Kind::kFrame) continue;
      const auto found = by_stamp.find(item.frame.timestamp_us);
      if (found != by_stamp.end()) {
        const StampedPose& pose = poses[found->second];
        item.frame.sequence = pose.sequence;
        reintegrator.fuse(item.frame, pose.T_odom_camera, motion[found->second]);
        ++fused;
        if (const auto keyframe = keyframes.find(pose.sequence); keyframe != keyframes.end())
          ++(reintegrator.shows(keyframe->second->depth) ? shown : not_shown);
        if (not_shown > shown + kDoubtful) throw Error(kOtherMission);
      }
      progress(kFusing * std::min(1.0, static_cast<double>(++read) / static_cast<double>(count)));
    }
  }
  if (fused == 0 || not_shown > shown) throw Error(kOtherMission);
  const TileGrid grid{reintegrator.tile_side()};
  TileWriter writer(tiles, grid);
  const auto take = [&](const CloudSlice& slice) {
    WeldedMesh mesh = weld(std::span(&slice, 1));
    if (mesh.triangles.empty()) return;
    const auto [a, b, c] = mesh.triangles.front();
    writer.add({grid.tile_of(0, owning_cell({mesh.keys[a], mesh.keys[b], mesh.keys[c]})), std::move(mesh)});
  };
  reintegrator.extract(take, [&](double share) { progress(kFusing + (1 - kFusing) * share); });
  writer.finish();
}

}  // namespace kt
