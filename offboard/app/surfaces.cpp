// Group by group, from slices or frames.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/app/surfaces.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "offboard/app/group_surface.h"
#include "offboard/app/logged_config.h"
#include "shared/core/check.h"

namespace kt {
namespace {

std::vector<MissionFrames> frames_of(const MapOptions& options, const JoinedSession& joined) {
  const Calibration& calibration = joined.session.header.calibration;
  std::vector<MissionFrames> missions;
  for (size_t i = 0; i < options.logs.size(); ++i) {
    MissionFrames mission;
    mission.source = options.frames.empty() ? open_source("lcm-log:" + options.logs[i].string())
                                            : open_source(options.frames[i], calibration);
    mission.first_sequence = joined.missions[i].sequence;
    mission.end_sequence =
        i + 1 < options.logs.size() ? joined.missions[i + 1].sequence : std::numeric_limits<int64_t>::max();
    missions.push_back(std::move(mission));
  }
  return missions;
}

}  // namespace

SurfaceSource surface_source(const MapOptions& options, const Session& session,
                             std::span<const LogIndex> indices) {
  if (options.surface == SurfaceChoice::kSlices) return SurfaceSource::kSlices;
  if (!options.frames.empty()) {
    if (options.frames.size() != options.logs.size())
      throw Error("--frames must name one recording for each log, in their order");
    return SurfaceSource::kFrames;
  }
  const auto without = std::find_if(indices.begin(), indices.end(),
                                    [](const LogIndex& index) { return index.raw_frames == 0; });
  const bool has_camera = !session.integrity.session_missing;
  if (without == indices.end() && has_camera) return SurfaceSource::kFrames;
  if (options.surface == SurfaceChoice::kAuto) return SurfaceSource::kSlices;
  const auto log = without == indices.end() ? 0 : static_cast<size_t>(without - indices.begin());
  throw Error(options.logs[log].string() +
              (has_camera
                   ? " holds no raw frames: record with --record-raw, or name the recording with --frames"
                   : " has lost its session event, and with it the calibration of the raw frames"));
}

ReintegrationConfig fusion_of(const MapOptions& options, const Session& session) {
  double voxel_size_m = options.voxel_size_m;
  if (voxel_size_m <= 0)
    voxel_size_m = session.slices.empty() ? VolumeConfig{}.voxel_size_m : session.slices.front().voxel_size_m;
  return reintegration_config(session.header, voxel_size_m);
}

std::vector<GroupSurface> make_surfaces(SurfaceSource source, const ReintegrationConfig& fusion,
                                        std::span<const Group> groups, const JoinedSession& joined,
                                        std::span<const LoopClosure> closures, const MapOptions& options,
                                        const std::function<std::filesystem::path(const Group&)>& tiles,
                                        const TellShare& tell) {
  std::vector<MissionLog> logs;
  for (size_t i = 0; i < options.logs.size(); ++i) logs.push_back({options.logs[i], joined.missions[i]});
  std::vector<GroupSurface> surfaces;
  for (const Group& group : groups) {
    const auto done = static_cast<double>(surfaces.size()), all = static_cast<double>(groups.size());
    const auto tell_of_group = [&](double share) { tell((done + share) / all); };
    GroupSurface& surface = surfaces.emplace_back();
    if (source == SurfaceSource::kSlices || group.good_frames() == 0) {
      surface_of_slices(group, logs, {closures, {}, options.threads}, tiles(group), tell_of_group,
                        &surface.is_in_place);
    } else {
      surface.source = SurfaceSource::kFrames;
      constexpr double kLooking = 0.3;  // of the work
      FrameGains gains;
      if (options.even_exposure) {
        gains = gains_of_frames(group, frames_of(options, joined), joined.session, options.device,
                                fusion.preprocess, [&](double share) { tell_of_group(kLooking * share); });
        surface.exposure = gains.figures;
      }
      const double looked = options.even_exposure ? kLooking : 0;
      surface_of_frames(group, frames_of(options, joined), joined.session, gains, options.device, fusion,
                        tiles(group), [&](double share) { tell_of_group(looked + (1 - looked) * share); });
    }
  }
  return surfaces;
}

}  // namespace kt
