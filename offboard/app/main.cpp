// kintsugi-map: turns the log of a mission into a map.
// SPDX-License-Identifier: BSD-3-Clause
#include <cstdio>
#include <map>

#include "offboard/app/make_map.h"
#include "onboard/source/frame_source.h"
#include "shared/cli/program.h"
#include "shared/cli/progress_line.h"

int main(int argc, char** argv) {
  kt::MapOptions options;
  std::string device = "auto";
  int threads = 0;
  double keep_share = 1;
  const std::map<std::string, kt::LoopSource> loop_sources{
      {"search", kt::LoopSource::kSearch}, {"log", kt::LoopSource::kLog}, {"none", kt::LoopSource::kNone}};
  const std::map<std::string, kt::SurfaceChoice> surfaces{{"auto", kt::SurfaceChoice::kAuto},
                                                          {"slices", kt::SurfaceChoice::kSlices},
                                                          {"frames", kt::SurfaceChoice::kFrames}};
  const std::map<std::string, kt::LoopRobustness> robust{{"gnc", kt::LoopRobustness::kGnc},
                                                         {"none", kt::LoopRobustness::kNone}};
  const std::map<std::string, kt::MapStage> stages{
      {"load", kt::MapStage::kLoad},         {"loops", kt::MapStage::kLoops},
      {"optimise", kt::MapStage::kOptimise}, {"refine", kt::MapStage::kRefine},
      {"deform", kt::MapStage::kSurface},    {"fuse", kt::MapStage::kSurface},
      {"mesh", kt::MapStage::kMesh}};
  const char* const stage_names = "{load,loops,optimise,refine,deform,fuse,mesh}";
  const std::map<std::string, bool> exposures{{"even", true}, {"asis", false}};
  CLI::App app("Turns the logs of missions into map.ply, trajectory.txt, poses.g2o and report.json.",
               "kintsugi-map");
  app.add_option("logs", options.logs,
                 "log written by kintsugi-collect; several of one camera are joined by what they both saw")
      ->required();
  app.add_option("--output,-o", options.output, "folder to write to; made where it is missing")->required();
  app.add_option("--loops", options.loops.source,
                 "loop closures: search among all keyframes, those in the log, or none")
      ->transform(CLI::CheckedTransformer(loop_sources).description("{search,log,none}"))
      ->default_str("search");
  app.add_option("--robust", options.graph.robustness, "whether false loop closures are looked for")
      ->transform(CLI::CheckedTransformer(robust).description("{gnc,none}"))
      ->default_str("gnc");
  app.add_flag("!--no-refine", options.refines,
               "leave poses and calibration as the pose graph and the log have them: no bundle adjustment");
  app.add_option(
         "--surface", options.surface,
         "frames: all frames fused anew at their optimised poses; slices: the collector's, bent to where the "
         "poses are; auto: frames where the log or --frames has them")
      ->transform(CLI::CheckedTransformer(surfaces).description("{auto,slices,frames}"))
      ->default_str("auto");
  app.add_flag("--surface-constraints", options.surface_constraints,
               "slices are bent by the points of loop closures too, not by the poses alone");
  app.add_option(
      "--frames", options.frames,
      "the recordings that the logs were made from, in their order: " + kt::joined(kt::source_specs()));
  app.add_option("--voxel-size", options.voxel_size_m, "of the surface fused anew (m); 0: the collector's")
      ->check(CLI::Range(0.0, 1.0));
  app.add_option(
         "--exposure", options.even_exposure,
         "even: frames fused anew are brought to one exposure and white balance, where their views agree "
         "better then; asis: as they were recorded")
      ->transform(CLI::CheckedTransformer(exposures).description("{even,asis}"))
      ->default_str("even");
  app.add_option("--format,-f", options.formats,
                 "of the map, one or several: ply, obj, glb (glTF), pcd (points)")
      ->delimiter(',')
      ->check(CLI::IsMember({"ply", "obj", "glb", "pcd"}))
      ->default_str("ply");
  app.add_option("--min-island", options.islands.min_area_m2,
                 "pieces of the mesh of less area (m2) are dropped; 0: none")
      ->check(CLI::Range(0.0, 1e6))
      ->capture_default_str();
  app.add_option("--simplify", keep_share, "share of the triangles to keep, by quadric error edge collapse")
      ->check(CLI::Range(0.001, 1.0));
  app.add_option("--from", options.from,
                 "make this stage and those behind it anew, though an earlier run has left their results")
      ->transform(CLI::CheckedTransformer(stages).description(stage_names));
  app.add_option(
         "--until", options.until,
         "stop after this stage; the same call without goes on there. deform and fuse are one: which, "
         "depends on --surface")
      ->transform(CLI::CheckedTransformer(stages).description(stage_names))
      ->default_str("mesh");
  app.add_flag("!--no-stages", options.keeps_stages,
               "keep no results of stages in OUTPUT/stages, and take none from there");
  app.add_option("--device,-d", device, "where frames are fused: auto, cpu or cuda")->capture_default_str();
  app.add_option("--threads,-t", threads, "of the CPU; 0: one per core")->check(CLI::Range(0, 1024));
  return kt::run_program(app, argc, argv, [&] {
    options.device = kt::exec::Device::from_name(device, threads);
    options.threads = threads;
    if (options.islands.min_area_m2 == 0) options.islands.min_triangles = 0;
    if (keep_share < 1) options.simplify = kt::SimplifyConfig{.keep_share = keep_share};
    kt::ProgressLine progress;
    const auto show = [&progress](const std::string& stage, double share, double seconds_to_go) {
      const bool tells = share < 1 && seconds_to_go >= 0;
      progress.show(share, stage + (tells ? ", " + kt::rough_duration(seconds_to_go) + " to go" : ""));
    };
    std::fputs(kt::make_map(options, show).c_str(), stdout);
  });
}
