// Load, place, map, write; group by group.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/app/make_map.h"

#include <algorithm>
#include <chrono>
#include <limits>
#include <sys/resource.h>
#include <utility>

#include "offboard/app/group_surface.h"
#include "offboard/app/segment_folders.h"
#include "offboard/report/map_report.h"
#include "offboard/session/integrity_report.h"
#include "offboard/session/join_sessions.h"
#include "offboard/session/load_session.h"
#include "shared/core/check.h"
#include "shared/io/file.h"

namespace kt {
namespace {

int64_t peak_memory_bytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return int64_t{usage.ru_maxrss} * 1024;
}

// Runs the steps, tells of them, and keeps their wall times.
class Steps {
 public:
  explicit Steps(const StepProgress& progress) : progress_(progress) {}

  template <typename Action>
  auto run(const std::string& name, Action&& action) {
    const auto tell = [this, &name](double share) {
      if (progress_) progress_(name, share);
    };
    tell(0);
    const auto start = std::chrono::steady_clock::now();
    auto result = action(tell);
    times_s_.emplace_back(name,
                          std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
    tell(1);
    return result;
  }
  const std::vector<std::pair<std::string, double>>& times_s() const { return times_s_; }

 private:
  const StepProgress& progress_;
  std::vector<std::pair<std::string, double>> times_s_;
};

// The missions of all logs as one.
JoinedSession load_all(const MapOptions& options, const std::function<void(double)>& tell) {
  std::vector<Session> sessions;
  for (const std::filesystem::path& log : options.logs) {
    const auto done = static_cast<double>(sessions.size()), all = static_cast<double>(options.logs.size());
    sessions.push_back(load_session(log, [&](double share) { tell((done + share) / all); }));
    if (sessions.back().trajectory.empty()) {
      throw Error(log.string() +
                  " holds no poses, so it is no mission: where it holds raw frames, run kintsugi-collect " +
                  "--input lcm-log:" + log.string() + " first");
    }
  }
  return join_sessions(std::move(sessions));
}

// The frames that are fused anew; none where the slices serve.
std::vector<MissionFrames> frames_of(const MapOptions& options, const JoinedSession& joined) {
  if (options.surface == SurfaceChoice::kSlices) return {};
  if (!options.frames.empty() && options.frames.size() != options.logs.size())
    throw Error("--frames must name one recording for each log, in their order");
  const Calibration& calibration = joined.session.header.calibration;
  std::vector<MissionFrames> missions;
  for (size_t i = 0; i < options.logs.size(); ++i) {
    MissionFrames mission;
    const std::string log = options.logs[i].string();
    try {
      mission.source = options.frames.empty() ? open_source("lcm-log:" + log)
                                              : open_source(options.frames[i], calibration);
    } catch (const Error&) {
      if (!options.frames.empty()) throw;
      if (options.surface == SurfaceChoice::kAuto) return {};
      throw Error(log +
                  " holds no raw frames: record with --record-raw, or name the recording with --frames");
    }
    mission.first_sequence = joined.first_sequences[i];
    mission.end_sequence =
        i + 1 < options.logs.size() ? joined.first_sequences[i + 1] : std::numeric_limits<int64_t>::max();
    missions.push_back(std::move(mission));
  }
  return missions;
}

double voxel_size_of(const MapOptions& options, const Session& session) {
  if (options.voxel_size_m > 0) return options.voxel_size_m;
  return session.slices.empty() ? VolumeConfig{}.voxel_size_m : session.slices.front().voxel_size_m;
}

GroupMap map_of(Group group, const JoinedSession& joined, double voxel_size_m, const MapOptions& options,
                const std::function<void(double)>& tell) {
  GroupMap map;
  const std::vector<MissionFrames> missions =
      group.good_frames() > 0 ? frames_of(options, joined) : std::vector<MissionFrames>();
  if (missions.empty()) {
    map.map = surface_of_slices(group, options.placement.threads, &map.is_in_place);
  } else {
    map.surface = SurfaceSource::kFrames;
    ReintegrationConfig config;
    config.volume.voxel_size_m = voxel_size_m;
    constexpr double kLooking = 0.15;  // of the work
    if (options.even_exposure) {
      map.gains = gains_of_frames(group, frames_of(options, joined), joined.session, options.device,
                                  config.preprocess, [&](double share) { tell(kLooking * share); });
    }
    map.map = surface_of_frames(group, missions, joined.session, map.gains.value_or(FrameGains{}),
                                options.device, config, options.output / "bricks.tmp",
                                [&](double share) { tell(kLooking + (1 - kLooking) * share); });
  }
  map.islands = drop_small_islands(options.islands, map.map);
  if (options.simplify) simplify(*options.simplify, map.map);
  map.group = std::move(group);
  return map;
}

// What has neither good frames nor surface is not written.
std::string folder_of(const GroupMap& map, bool is_main) {
  if (is_main) return ".";
  return map.group.good_frames() > 0 || !map.map.triangles.empty() ? segment_folder(map.group.number()) : "";
}

std::string size_text(const Mesh& map) {
  return std::to_string(map.vertices.size()) + " vertices, " + std::to_string(map.triangles.size()) +
         " triangles";
}

std::string loops_text(const PlacedMission& placed) {
  size_t believed = 0;
  for (const size_t edge : placed.measured.loop_edges) believed += placed.solution.edges[edge].weight > 0;
  return std::to_string(believed) + " of " + std::to_string(placed.measured.loop_edges.size()) +
         " proved closures believed, " + std::to_string(placed.candidates.size()) + " places compared";
}

// A line for each where there are several.
std::string groups_text(const std::vector<GroupMap>& maps) {
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

std::string warning_text(const std::vector<GroupMap>& maps) {
  std::string text;
  for (const GroupMap& map : maps) {
    if (map.is_in_place) continue;
    text += "warning: segment " + std::to_string(map.group.number()) +
            " would tear if its surface were bent to the optimised poses: it stands where odometry has it; " +
            "--frames with the recording fuses it anew\n";
  }
  return text;
}

// "map.ply, map.glb, "
std::string map_names(const std::vector<std::string>& formats) {
  std::string names;
  for (const std::string& format : formats) names += map_file(format) + ", ";
  return names;
}

std::string summary(const Session& session, const PlacedMission& placed, const std::vector<GroupMap>& maps,
                    size_t main, const MapOptions& options) {
  return "log:  " + integrity_text(session.integrity) + "\nloops: " + loops_text(placed) +
         "\nmap:  " + size_text(maps[main].map) + " from " +
         (maps[main].surface == SurfaceSource::kFrames ? "all frames" : "the collector's slices") +
         "\npath: " + std::to_string(maps[main].group.trajectory().size()) + " poses\nwritten to " +
         options.output.string() + ": " + map_names(options.formats) +
         "trajectory.txt, poses.g2o, report.json\n" + groups_text(maps) + warning_text(maps);
}

}  // namespace

std::string make_map(const MapOptions& options, const StepProgress& progress) {
  Steps steps(progress);
  JoinedSession joined = steps.run("load", [&](const auto& tell) { return load_all(options, tell); });
  Session& session = joined.session;
  create_folder(options.output);
  const PlacedMission placed =
      steps.run("place", [&](const auto& tell) { return place_mission(session, options.placement, tell); });
  const double voxel_size_m = voxel_size_of(options, session);
  std::vector<Group> groups = take_groups(session, placed);
  const size_t main = main_group(groups);
  const std::vector<GroupMap> maps = steps.run("surface", [&](const auto& tell) {
    std::vector<GroupMap> made;
    for (size_t i = 0; i < groups.size(); ++i) {
      const auto tell_of_group = [&](double share) {
        tell((static_cast<double>(i) + share) / static_cast<double>(groups.size()));
      };
      made.push_back(map_of(std::move(groups[i]), joined, voxel_size_m, options, tell_of_group));
      made.back().folder = folder_of(made.back(), i == main);
    }
    return made;
  });
  steps.run("write", [&](const auto& tell) {
    remove_segment_folders(options.output);
    for (size_t i = 0; i < maps.size(); ++i) {
      if (!maps[i].folder.empty()) write_group(options.output, maps[i], placed, options.formats);
      tell(static_cast<double>(i + 1) / static_cast<double>(maps.size()));
    }
    return true;
  });
  RunFigures run{{}, steps.times_s(), peak_memory_bytes()};
  for (const std::filesystem::path& log : options.logs) run.logs.push_back(log.string());
  write_file(options.output / "report.json", map_report(session, placed, maps, main, run));
  return summary(session, placed, maps, main, options);
}

}  // namespace kt
