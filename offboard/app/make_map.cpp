// Load, find loops, optimise, make the surface, write; each stage kept in a file.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/app/make_map.h"

#include <array>
#include <sys/resource.h>
#include <utility>

#include "offboard/app/expected_times.h"
#include "offboard/app/map_summary.h"
#include "offboard/app/segment_folders.h"
#include "offboard/app/stage_fields.h"
#include "offboard/app/stage_keys.h"
#include "offboard/app/surfaces.h"
#include "offboard/report/map_report.h"
#include "offboard/session/join_sessions.h"
#include "shared/core/check.h"
#include "shared/io/file.h"

namespace kt {
namespace {

int64_t peak_memory_bytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return int64_t{usage.ru_maxrss} * 1024;
}

// The missions of all logs as one; load(i, tell) loads one of them.
template <typename Load>
JoinedSession load_all(const MapOptions& options, const TellShare& tell, const Load& load) {
  std::vector<Session> sessions;
  for (const std::filesystem::path& log : options.logs) {
    const auto done = static_cast<double>(sessions.size()), all = static_cast<double>(options.logs.size());
    sessions.push_back(load(sessions.size(), [&](double share) { tell((done + share) / all); }));
    if (sessions.back().trajectory.empty()) {
      throw Error(log.string() +
                  " holds no poses, so it is no mission: where it holds raw frames, run kintsugi-collect " +
                  "--input lcm-log:" + log.string() + " first");
    }
  }
  return join_sessions(std::move(sessions));
}

// What has neither good frames nor surface is not written.
std::string folder_of(const GroupMap& map, bool is_main) {
  if (is_main) return ".";
  return map.group.good_frames() > 0 || !map.map.triangles.empty() ? segment_folder(map.group.number()) : "";
}

std::vector<GroupMap> finish_maps(std::vector<Group> groups, std::vector<GroupSurface> surfaces, size_t main,
                                  const MapOptions& options) {
  std::vector<GroupMap> maps;
  for (size_t i = 0; i < groups.size(); ++i) {
    GroupMap& map = maps.emplace_back();
    map.group = std::move(groups[i]);
    map.map = std::move(surfaces[i].mesh);
    map.surface = surfaces[i].source;
    map.is_in_place = surfaces[i].is_in_place;
    map.islands = drop_small_islands(options.islands, map.map);
    if (options.simplify) simplify(*options.simplify, map.map);
    map.folder = folder_of(map, i == main);
  }
  return maps;
}

std::vector<MapFile> write_maps(const std::vector<GroupMap>& maps, const PlacedMission& placed,
                                const MapOptions& options, const TellShare& tell) {
  std::vector<MapFile> files;
  remove_segment_folders(options.output);
  for (size_t i = 0; i < maps.size(); ++i) {
    if (maps[i].folder.empty()) continue;
    for (MapFile& file : write_group(options.output, maps[i], placed, options.formats))
      files.push_back(std::move(file));
    tell(static_cast<double>(i + 1) / static_cast<double>(maps.size()));
  }
  return files;
}

// The stages one after the other, and what each leaves to the next.
class MapRun {
 public:
  MapRun(const MapOptions& options, const StageProgress& progress)
      : options_(options),
        store_(options.keeps_stages ? options.output / "stages" : std::filesystem::path()),
        stages_(store_, progress) {}

  void load() {
    key_ = load_key(options_);
    indices_ = stages_.run(
        "load", key_,
        [this](const TellShare& tell) {
          std::vector<LogIndex> indices(options_.logs.size());
          joined_ = load_all(options_, tell, [&](size_t i, const Progress& progress) {
            return load_session(options_.logs[i], progress, &indices[i]);
          });
          create_folder(options_.output);
          return indices;
        },
        [this](const std::vector<LogIndex>& indices, const TellShare& tell) {
          joined_ = load_all(options_, tell, [&](size_t i, const Progress& progress) {
            return load_session(options_.logs[i], indices[i], progress);
          });
        });
    source_ = surface_source(options_, joined_.session, indices_);
    fusion_ = fusion_of(options_, joined_.session);
    expect_stages(joined_.session, source_, stages_.time_to_go());
    text_ += log_text(joined_.session);
  }

  void find_loops() {
    key_ = loops_key(key_, options_.loops);
    candidates_ = stages_.run("loops", key_, [this](const TellShare& tell) {
      return kt::find_loops(joined_.session, options_.loops, options_.threads, tell);
    });
    text_ += candidates_text(candidates_);
  }

  void optimise() {
    key_ = optimise_key(key_, options_.graph);
    MissionGraph measured = mission_graph(joined_.session.trajectory, candidates_);
    OptimisedGraph solution = stages_.run(
        "optimise", key_, [&](const TellShare&) { return solve_mission(measured, options_.graph); });
    placed_ =
        placed_mission(joined_.session, std::move(candidates_), std::move(measured), std::move(solution));
    text_ += placed_text(placed_);
  }

  void make_surface() {
    groups_ = take_groups(joined_.session, placed_);
    const bool fuses = source_ == SurfaceSource::kFrames;
    key_ = fuses ? fuse_key(key_, options_.frames, fusion_) : deform_key(key_);
    surfaces_ = stages_.run(fuses ? "fuse" : "deform", key_, [this](const TellShare& tell) {
      return make_surfaces(source_, fusion_, groups_, joined_, options_, tell);
    });
  }

  void write() {
    const size_t main = main_group(groups_);
    std::vector<GroupMap> maps;
    const std::vector<MapFile> files = stages_.run_always("mesh", [&](const TellShare& tell) {
      maps = finish_maps(std::move(groups_), std::move(surfaces_), main, options_);
      return write_maps(maps, placed_, options_, tell);
    });
    RunFigures run{{}, stages_.done(), peak_memory_bytes()};
    for (const std::filesystem::path& log : options_.logs) run.logs.push_back(log.string());
    write_file(options_.output / "report.json", map_report(joined_.session, placed_, maps, main, files, run));
    text_ += map_text(maps, main, options_);
  }

  std::string run() {
    constexpr std::array<void (MapRun::*)(), 5> kStages = {
        &MapRun::load, &MapRun::find_loops, &MapRun::optimise, &MapRun::make_surface, &MapRun::write};
    for (size_t i = 0; i <= static_cast<size_t>(options_.until); ++i) {
      if (options_.from && i == static_cast<size_t>(*options_.from)) stages_.make_all();
      (this->*kStages[i])();
    }
    text_ += stages_text(stages_);
    if (options_.until != MapStage::kMesh) text_ += stopped_text(stages_, store_);
    return text_;
  }

 private:
  const MapOptions& options_;
  StageStore store_;
  StageRunner stages_;
  Digest key_;  // of the stage that was run last
  std::string text_;

  JoinedSession joined_;  // without poses and slices once the groups have them
  std::vector<LogIndex> indices_;
  SurfaceSource source_ = SurfaceSource::kSlices;
  ReintegrationConfig fusion_;
  std::vector<LoopClosure> candidates_;
  PlacedMission placed_;
  std::vector<Group> groups_;
  std::vector<GroupSurface> surfaces_;
};

}  // namespace

std::string make_map(const MapOptions& options, const StageProgress& progress) {
  if (!options.keeps_stages && options.until != MapStage::kMesh)
    throw Error("a run that keeps no stages and stops before the last one would leave nothing");
  return MapRun(options, progress).run();
}

}  // namespace kt
