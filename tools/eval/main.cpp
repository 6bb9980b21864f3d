// kintsugi-eval: errors of a trajectory, of its measurements or of a mapped surface against ground truth.
// SPDX-License-Identifier: BSD-3-Clause
#include <csignal>
#include <cstdio>
#include <map>
#include <optional>
#include <string>

#include "offboard/map/double_layers.h"
#include "offboard/session/load_session.h"
#include "shared/cli/program.h"
#include "shared/io/file.h"
#include "shared/io/g2o.h"
#include "shared/io/ply.h"
#include "shared/io/trajectory_file.h"
#include "tools/eval/groundtruth.h"
#include "tools/eval/plot.h"
#include "tools/eval/report.h"

namespace kt {
namespace {

/// What the subcommands share.
struct Output {
  CLI::Option* json = nullptr;
  std::string json_file, plot_file;

  void add_to(CLI::App& app) {
    json = app.add_option("--json", json_file, "JSON instead of text, to standard output or to FILE")
               ->type_name("[FILE]")
               ->expected(0, 1);
  }
  void add_plot_to(CLI::App& app) {
    app.add_option("--plot", plot_file, "draw the errors (needs gnuplot)")->type_name("FILE.png");
  }
  void print(const std::string& text, const nlohmann::ordered_json& report) const {
    const bool to_stdout = json->count() > 0 && json_file.empty();
    if (!json_file.empty()) write_file(json_file, report.dump(2) + "\n");
    std::fputs(to_stdout ? (report.dump(2) + "\n").c_str() : text.c_str(), stdout);
  }
};

struct TrajectoryCommand {
  std::string estimate, groundtruth, graph, log;
  double max_difference_s = 0.02, delta = 1;
  DeltaUnit unit = DeltaUnit::kSeconds;
  Output output;

  void add_to(CLI::App& app) {
    app.add_option("--estimate", estimate, "trajectory to judge, TUM format")->required();
    app.add_option("--groundtruth", groundtruth,
                   "TUM trajectory, *.gt.freiburg, or tum:DIR, icl:DIR, 7scenes:DIR")
        ->required();
    app.add_option("--graph", graph,
                   "poses.g2o beside the estimate: whether its information is honest over --delta");
    app.add_option("--log", log,
                   "the mission's log: which revisits its loop closures found, and are they right")
        ->type_name("MISSION.lcm");
    app.add_option("--max-difference", max_difference_s, "largest difference of paired stamps (s)")
        ->capture_default_str()
        ->check(CLI::Range(1e-6, 60.0));
    app.add_option("--delta", delta, "span of the relative pose error and of --graph")
        ->capture_default_str()
        ->check(CLI::PositiveNumber);
    const std::map<std::string, DeltaUnit> units = {
        {"s", DeltaUnit::kSeconds}, {"m", DeltaUnit::kMetres}, {"frames", DeltaUnit::kFrames}};
    app.add_option("--delta-unit", unit, "s, m or frames")
        ->transform(CLI::CheckedTransformer(units))
        ->default_str("s");
    output.add_to(app);
    output.add_plot_to(app);
  }
  void run() const {
    const Trajectory truth = read_groundtruth(groundtruth), poses = read_trajectory(estimate);
    const AbsoluteTrajectoryError ate =
        absolute_trajectory_error(truth, poses, static_cast<int64_t>(max_difference_s * 1e6 + 0.5));
    const std::optional<RelativePoseError> rpe = relative_pose_error(truth, poses, delta, unit);
    if (!output.plot_file.empty()) plot_trajectory_error(ate, output.plot_file);
    std::string text = trajectory_text(ate, rpe);
    std::optional<Consistency> nees;
    if (!graph.empty()) {
      nees = consistency(truth, poses, read_g2o(graph), delta, unit);
      text += consistency_text(nees);
    }
    nlohmann::ordered_json json = trajectory_json(ate, rpe, nees);
    if (!log.empty()) {
      const LoopEvaluation loops = evaluate_loops(load_session(log), truth);
      text += loops_text(loops);
      json["loops"] = loops_json(loops);
    }
    output.print(text, json);
  }
};

struct SurfaceCommand {
  std::string map, groundtruth, seen, colours, align_estimate, align_groundtruth;
  bool mirror_groundtruth = false;
  SurfaceErrorOptions options;
  Output output;

  void add_to(CLI::App& app) {
    app.add_option("--map", map, "mesh to judge, PLY")->required();
    app.add_option("--groundtruth", groundtruth, "true surface, PLY")->required();
    app.add_option("--seen", seen,
                   "the part of the true surface that the camera saw, PLY; completeness is asked of it");
    app.add_option("--colours", colours,
                   "points of the true surface with colours, PLY; the map's are compared with them");
    auto* first =
        app.add_option("--align-estimate", align_estimate,
                       "trajectory that came with the map; aligning it to the true one places the map");
    auto* second =
        app.add_option("--align-groundtruth", align_groundtruth, "the true trajectory, as for 'trajectory'");
    first->needs(second);
    second->needs(first);
    app.add_flag("--mirror-groundtruth", mirror_groundtruth,
                 "mirror the true surface at y = 0: ICL-NUIM's own meshes need it");
    app.add_option("--threshold", options.threshold_m, "distance that counts as matched (m)")
        ->capture_default_str()
        ->check(CLI::PositiveNumber);
    app.add_option("--samples", options.samples, "points sampled on either surface")
        ->capture_default_str()
        ->check(CLI::Range(int64_t{1000}, int64_t{100'000'000}));
    output.add_to(app);
    output.add_plot_to(app);
  }
  Mesh read_truth(const std::string& path) const {
    return mirror_groundtruth ? mirrored_y(read_ply(path)) : read_ply(path);
  }
  void run() const {
    Pose T_groundtruth_map = Pose::Identity();
    if (!align_estimate.empty()) {
      T_groundtruth_map = align_poses(read_groundtruth(align_groundtruth), read_trajectory(align_estimate));
    }
    const Mesh truth = read_truth(groundtruth);
    const Mesh made = read_ply(map);
    const SurfaceError error =
        surface_error(made, truth, seen.empty() ? truth : read_truth(seen), T_groundtruth_map, options);
    if (!output.plot_file.empty()) plot_surface_error(error, options.threshold_m, output.plot_file);
    std::string text = surface_text(error, options);
    nlohmann::ordered_json json = surface_json(error, options);
    if (!colours.empty()) {
      const ColourError colour = colour_error(made, read_truth(colours), T_groundtruth_map);
      text += colour_text(colour);
      json["colour"] = colour_json(colour);
    }
    output.print(text, json);
  }
};

struct EdgesCommand {
  std::string log, groundtruth, graph;
  Output output;

  void add_to(CLI::App& app) {
    app.add_option("--log", log, "the mission's log")->required()->type_name("MISSION.lcm");
    app.add_option("--groundtruth", groundtruth, "the true trajectory, as for 'trajectory'")->required();
    app.add_option("--graph", graph,
                   "poses.g2o that kintsugi-map made of the log: judges the closures that it believed, not "
                   "those that the collector accepted");
    output.add_to(app);
  }
  void run() const {
    const Trajectory truth = read_groundtruth(groundtruth);
    const Session session = load_session(log);
    std::optional<PoseGraph> believed;
    if (!graph.empty()) believed = read_g2o(graph);
    const EdgeConsistency edges = edge_consistency(session, truth, believed ? &*believed : nullptr);
    output.print(edges_text(edges), edges_json(edges));
  }
};

struct LayersCommand {
  std::string map;
  Output output;

  void add_to(CLI::App& app) {
    app.add_option("--map", map, "mesh with normals, PLY")->required();
    output.add_to(app);
  }
  void run() const {
    const DoubleLayers layers = count_double_layers(read_ply(map));
    output.print(layers_text(layers), layers_json(layers));
  }
};

}  // namespace
}  // namespace kt

int main(int argc, char** argv) {
  std::signal(SIGPIPE, SIG_IGN);  // a plotter that dies early is an error of the plot, not our end
  CLI::App app("Compares what Kintsugi made with the truth.", "kintsugi-eval");
  app.require_subcommand(1);
  kt::TrajectoryCommand trajectory;
  kt::SurfaceCommand surface;
  CLI::App* trajectory_app = app.add_subcommand("trajectory", "absolute and relative error of a trajectory");
  CLI::App* surface_app = app.add_subcommand("surface", "accuracy, completeness and F-score of a mesh");
  kt::EdgesCommand edges;
  CLI::App* edges_app =
      app.add_subcommand("edges", "whether the information of closures and odometry is honest, edge by edge");
  kt::LayersCommand layers;
  CLI::App* layers_app = app.add_subcommand("layers", "how much of a mesh shows one surface twice");
  layers.add_to(*layers_app);
  trajectory.add_to(*trajectory_app);
  surface.add_to(*surface_app);
  edges.add_to(*edges_app);
  return kt::run_program(app, argc, argv, [&] {
    if (trajectory_app->parsed()) trajectory.run();
    if (surface_app->parsed()) surface.run();
    if (edges_app->parsed()) edges.run();
    if (layers_app->parsed()) layers.run();
  });
}
