// kintsugi-graph: optimises pose graphs in g2o files, and puts false loops into them.
// SPDX-License-Identifier: BSD-3-Clause
#include <chrono>
#include <cstdio>
#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "offboard/pose_graph/chordal.h"
#include "offboard/pose_graph/optimise.h"
#include "shared/cli/program.h"
#include "shared/io/g2o.h"
#include "tools/graph/false_loops.h"

namespace kt {
namespace {

/// What both subcommands share.
struct Files {
  std::string input, output;

  void add_to(CLI::App& app) {
    app.add_option("input", input, "pose graph to read")->required()->type_name("IN.g2o");
    app.add_option("--output", output, "pose graph to write")->required()->type_name("OUT.g2o");
  }
};

std::vector<Pose> poses_of(const PoseGraph& graph) {
  std::vector<Pose> poses;
  for (const PoseGraph::Node& node : graph.nodes) poses.push_back(node.T_world_node);
  return poses;
}

// The loops that were found false and why, by their place among the edges of the file and the nodes that they
// tie.
nlohmann::ordered_json rejected(const PoseGraph& graph, const std::vector<size_t>& loops,
                                const OptimisedGraph& result) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const size_t loop : loops) {
    const LoopOutcome outcome = result.edges[loop].outcome;
    if (outcome == LoopOutcome::kAccepted) continue;
    const PoseGraph::Edge& edge = graph.edges[loop];
    list.push_back({{"edge", loop}, {"from", edge.from}, {"to", edge.to}, {"outcome", to_string(outcome)}});
  }
  return list;
}

struct OptimiseCommand {
  Files files;
  PoseGraphOptions options;
  bool json = false;

  void add_to(CLI::App& app) {
    files.add_to(app);
    const std::map<std::string, GraphResidual> residuals = {{"se3", GraphResidual::kSe3},
                                                            {"chordal", GraphResidual::kChordal}};
    app.add_option("--residual", options.least_squares.residual, "what is minimised: se3 or chordal")
        ->transform(CLI::CheckedTransformer(residuals))
        ->default_str("se3");
    const std::map<std::string, LoopRobustness> robust = {{"none", LoopRobustness::kNone},
                                                          {"gnc", LoopRobustness::kGnc}};
    app.add_option("--robust", options.robustness, "whether false loops are looked for: none or gnc")
        ->transform(CLI::CheckedTransformer(robust))
        ->default_str("gnc");
    app.add_option("--max-iterations", options.least_squares.max_iterations, "of the last solve")
        ->capture_default_str()
        ->check(CLI::Range(1, 10000));
    app.add_flag("--json", json, "JSON instead of text");
  }

  void run() const {
    PoseGraph graph = read_g2o(files.input);
    const std::vector<size_t> loops = edges_out_of_order(graph);
    const double chordal_before = chordal_objective(graph, poses_of(graph));
    const auto start = std::chrono::steady_clock::now();
    const OptimisedGraph result = optimise(graph, loops, options);
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
    for (size_t node = 0; node < graph.nodes.size(); ++node) {
      graph.nodes[node].T_world_node = result.T_world_node[node];
    }
    write_g2o(files.output, graph);

    nlohmann::ordered_json report;
    report["nodes"] = graph.nodes.size();
    report["edges"] = graph.edges.size();
    report["repaired_edges"] = result.repaired_edges;
    report["components"] = result.components.anchor.size();
    report["objective_before"] = result.objective_before;
    report["objective_after"] = result.objective_after;
    report["chordal_before"] = chordal_before;
    report["chordal_after"] = chordal_objective(graph, result.T_world_node);
    report["iterations"] = result.iterations;
    report["converged"] = result.converged;
    report["solves"] = result.solves;
    report["odometry_scale"] = result.odometry_scale;
    report["loop_scale"] = result.loop_scale;
    report["seconds"] = seconds.count();
    std::map<std::string, int> outcomes;
    for (const size_t loop : loops) ++outcomes[to_string(result.edges[loop].outcome)];
    report["loops"] = outcomes;
    report["rejected_loops"] = rejected(graph, loops, result);
    if (json) {
      std::puts(report.dump(2).c_str());
      return;
    }
    for (const auto& [name, value] : report.items()) {
      if (value.is_primitive()) std::printf("%-17s %s\n", name.c_str(), value.dump().c_str());
    }
    for (const auto& [outcome, count] : outcomes) std::printf("loops %s: %d\n", outcome.c_str(), count);
  }
};

struct InjectCommand {
  Files files;
  FalseLoops options;

  void add_to(CLI::App& app) {
    files.add_to(app);
    app.add_option("--share", options.share, "of all loops that will be false")
        ->capture_default_str()
        ->check(CLI::Range(0.0, 0.95));
    const std::map<std::string, FalseLoopKind> kinds = {{"random", FalseLoopKind::kRandom},
                                                        {"alias", FalseLoopKind::kAlias}};
    app.add_option(
           "--kind", options.kind,
           "random: each alone; alias: groups that agree with each other, as of places that look alike")
        ->transform(CLI::CheckedTransformer(kinds))
        ->default_str("random");
    app.add_option("--seed", options.seed, "which false loops")->capture_default_str();
  }

  void run() const {
    const PoseGraph graph = read_g2o(files.input), result = with_false_loops(graph, options);
    write_g2o(files.output, result);
    std::printf("%zu false loops added to %zu\n", result.edges.size() - graph.edges.size(),
                edges_out_of_order(graph).size());
  }
};

}  // namespace
}  // namespace kt

int main(int argc, char** argv) {
  CLI::App app("Optimises pose graphs. An edge that is not between nodes consecutive in the file is a loop.",
               "kintsugi-graph");
  app.require_subcommand(1);
  kt::OptimiseCommand optimise;
  kt::InjectCommand inject;
  CLI::App* optimise_app = app.add_subcommand("optimise", "the most likely poses");
  CLI::App* inject_app = app.add_subcommand("inject", "adds false loops, to see what becomes of them");
  optimise.add_to(*optimise_app);
  inject.add_to(*inject_app);
  return kt::run_program(app, argc, argv, [&] { optimise_app->parsed() ? optimise.run() : inject.run(); });
}
