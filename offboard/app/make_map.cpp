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
#include "offboard/map/mesh_of_tiles.h"
#include "offboard/report/map_report.h"
#include "offboard/session/join_sessions.h"
#include "shared/core/check.h"
#include "shared/io/calibration_file.h"
#include "shared/io/file.h"
#include "shared/wire/log_parts.h"

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
  return map.group.good_frames() > 0 || map.map.mesh->triangles() > 0 ? segment_folder(map.group.number())
                                                                      : "";
}

// The stages one after the other, and what each leaves to the next.
class MapRun {
 public:
  MapRun(const MapOptions& options, const StageProgress& progress)
      : options_(options),
        store_(options.output / (options.keeps_stages ? "stages" : "stages.tmp"), options.keeps_stages),
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

  void refine() {
    key_ = refine_key(key_, options_.refines);
    refinement_ = stages_.run("refine", key_, [&](const TellShare& tell) {
      if (!options_.refines) return Refinement{};
      return kt::refine(joined_.session, placed_.measured, placed_.solution, options_.threads, tell);
    });
    if (!refinement_.T_world_camera.empty()) placed_.T_world_camera = refinement_.T_world_camera;
    Calibration& calibration = joined_.session.header.calibration;
    calibration = changed(calibration, refinement_.change);
    text_ += refined_text(refinement_);
  }

  void make_surface() {
    groups_ = take_groups(joined_.session, placed_);
    const bool fuses = source_ == SurfaceSource::kFrames;
    key_ = fuses ? fuse_key(key_, options_.frames, fusion_, options_.even_exposure)
                 : deform_key(key_, options_.surface_constraints);
    surface_stage_ = fuses ? "fuse" : "deform";
    std::vector<LoopClosure> closures;  // whose points bend the surface
    if (options_.surface_constraints && placed_.is_optimised()) closures = placed_.believed_closures();
    surfaces_ = stages_.run(surface_stage_, key_, [&](const TellShare& tell) {
      store_.open();
      const auto tiles = [this](const Group& group) { return store_.part(surface_stage_, group.number()); };
      return make_surfaces(source_, fusion_, groups_, joined_, closures, options_, tiles, tell);
    });
  }

  void make_mesh() {
    const size_t main = main_group(groups_);
    const std::vector<GroupMap> maps =
        stages_.run_always("mesh", [&](const TellShare& tell) { return write_maps(main, tell); });
    write_corrected_calibration();
    RunFigures run{{}, stages_.done(), peak_memory_bytes()};
    for (const std::filesystem::path& log : options_.logs) run.logs.push_back(log.string());
    write_file(options_.output / "report.json",
               map_report(joined_.session, placed_, refinement_, maps, main, files_, run));
    text_ += map_text(maps, main, options_);
  }

  std::string run() {
    constexpr std::array<void (MapRun::*)(), 6> kStages = {&MapRun::load,         &MapRun::find_loops,
                                                           &MapRun::optimise,     &MapRun::refine,
                                                           &MapRun::make_surface, &MapRun::make_mesh};
    for (size_t i = 0; i <= static_cast<size_t>(options_.until); ++i) {
      if (options_.from && i == static_cast<size_t>(*options_.from)) stages_.make_all();
      (this->*kStages[i])();
    }
    text_ += stages_text(stages_);
    if (options_.until != MapStage::kMesh) text_ += stopped_text(stages_, store_);
    return text_;
  }

 private:
  std::vector<GroupMap> write_maps(size_t main, const TellShare& tell) {
    constexpr double kMeshing = 0.6;  // of the work
    std::vector<GroupMap> maps;
    remove_segment_folders(options_.output);
    for (size_t i = 0; i < groups_.size(); ++i) {
      const auto tell_of_group = [&](double share) {
        tell((static_cast<double>(i) + share) / static_cast<double>(groups_.size()));
      };
      GroupMap& map = maps.emplace_back();
      const int number = groups_[i].number();
      map.map =
          mesh_of_tiles(TileFile(store_.part(surface_stage_, number)), {options_.islands, options_.simplify},
                        store_.part("mesh", number), [&](double share) { tell_of_group(kMeshing * share); });
      map.group = std::move(groups_[i]);
      map.surface = surfaces_[i].source;
      map.is_in_place = surfaces_[i].is_in_place;
      map.exposure = surfaces_[i].exposure;
      map.folder = folder_of(map, i == main);
      if (map.folder.empty()) continue;
      for (MapFile& file :
           write_group(options_.output, map, placed_, joined_.session.header.calibration, options_.formats))
        files_.push_back(std::move(file));
      tell_of_group(1);
    }
    return maps;
  }

  // For the camera's next mission; that of an earlier run is no longer true.
  void write_corrected_calibration() {
    const std::filesystem::path path = options_.output / kCorrectedCalibration;
    if (refinement_.change.is_none()) return remove_file(path);
    write_calibration(path, joined_.session.header.calibration);
    files_.push_back(described(options_.output, path));
  }

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
  Refinement refinement_;
  std::vector<Group> groups_;
  std::string surface_stage_;
  std::vector<GroupSurface> surfaces_;
  std::vector<MapFile> files_;
};

}  // namespace

std::string make_map(const MapOptions& options, const StageProgress& progress) {
  if (!options.keeps_stages && options.until != MapStage::kMesh)
    throw Error("a run that keeps no stages and stops before the last one would leave nothing");
  MapOptions chosen = options;
  chosen.logs = without_later_parts(options.logs);
  return MapRun(chosen, progress).run();
}

}  // namespace kt
