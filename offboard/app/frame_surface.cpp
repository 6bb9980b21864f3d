// Re-integration of one group.
// SPDX-License-Identifier: BSD-3-Clause
#include <map>
#include <utility>

#include "offboard/app/group_surface.h"
#include "offboard/exposure/exposure_estimator.h"
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

FrameGains gains_of_frames(const Group& group, std::span<const MissionFrames> missions,
                           const Session& session, const exec::Device& device, const PreprocessConfig& config,
                           const std::function<void(double)>& progress) {
  ExposureEstimator estimator(device, session.header.calibration, config);
  for_each_placed_frame(
      group.trajectory(), missions,
      [&](const RgbdFrame& frame, const Pose& T_world_camera, size_t) {
        estimator.add(frame, T_world_camera);
      },
      progress);
  return estimator.finish();
}

void surface_of_frames(const Group& group, std::span<const MissionFrames> missions, const Session& session,
                       const FrameGains& gains, const exec::Device& device, const ReintegrationConfig& config,
                       const std::filesystem::path& tiles, const std::function<void(double)>& progress) {
  constexpr double kFusing = 0.9;  // of the work
  const Trajectory poses = group.trajectory();
  const std::vector<Vector6d> motion = velocities(poses);
  Reintegrator reintegrator(device, session.header.calibration, config, tiles.string() + ".bricks");
  std::map<int64_t, const Keyframe*> keyframes;  // by sequence
  for (const Keyframe& keyframe : session.keyframes) keyframes.emplace(keyframe.sequence, &keyframe);
  int64_t fused = 0, shown = 0, not_shown = 0;
  const auto fuse = [&](const RgbdFrame& frame, const Pose& T_world_camera, size_t pose) {
    reintegrator.fuse(frame, T_world_camera, motion[pose], gains.factor(frame.sequence));
    ++fused;
    if (const auto keyframe = keyframes.find(frame.sequence); keyframe != keyframes.end())
      ++(reintegrator.shows(keyframe->second->depth) ? shown : not_shown);
    if (not_shown > shown + kDoubtful) throw Error(kOtherMission);
  };
  for_each_placed_frame(poses, missions, fuse, [&](double share) { progress(kFusing * share); });
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
