// kintsugi-deformation-bench: how well bent missions are straightened, and how long ten million vertices
// take.
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <functional>
#include <numbers>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "offboard/deformation/constraints.h"
#include "offboard/deformation/deform.h"
#include "offboard/deformation/solve_deformation.h"
#include "tools/bench/bent_mission.h"

namespace kt::bench {
namespace {

enum class Start { kPoses, kIdentity };
enum class Terms { kNone, kCameras, kCamerasAndSurface };  // kNone: the nodes stay where they start

struct Variant {
  std::string name;
  DeformationConfig config;
  Terms terms = Terms::kCameras;
  Start start = Start::kPoses;
};

struct Accuracy {
  double mean_mm = 0, p95_mm = 0;  ///< distance of the vertices from their true places
  double seam_mm = 0;  ///< 95th percentile of what half a second more in pose_sequence moves a vertex
  double gap_mm = 0;   ///< root mean square between the two sightings of the points of loops
};

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

double p95(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values.empty() ? 0 : values[static_cast<size_t>(0.95 * static_cast<double>(values.size() - 1))];
}

using Mover = std::function<void(std::span<SliceVertex>)>;

std::vector<SliceVertex> moved(const Mover& mover, std::vector<SliceVertex> vertices) {
  mover(vertices);
  return vertices;
}

// Each vertex by the motion of the pose that saw it last, the simplest deformation there is.
void move_by_own_pose(const BentMission& mission, std::span<SliceVertex> vertices) {
  for (SliceVertex& vertex : vertices) {
    const size_t i = std::min<size_t>(vertex.pose_sequence, mission.before.size() - 1);
    const Pose T_world_odom = mission.after[i] * mission.before[i].T_odom_camera.inverse(Eigen::Isometry);
    const Eigen::Vector3f p = (T_world_odom * to_eigen(vertex.p_odom)).cast<float>();
    vertex.p_odom = {p.x(), p.y(), p.z()};
  }
}

// Both sightings of every point of the loops, pair by pair, as odometry placed them.
std::vector<SliceVertex> sightings(const BentMission& mission) {
  std::vector<SliceVertex> vertices;
  const auto add = [&](int64_t frame, Vec3f p_camera) {
    const Pose& T_odom_camera = mission.before[static_cast<size_t>(frame)].T_odom_camera;
    const Eigen::Vector3f p = (T_odom_camera * to_eigen(p_camera)).cast<float>();
    vertices.push_back({{}, {p.x(), p.y(), p.z()}, {0, 0, 1}, {}, 1, static_cast<uint32_t>(frame)});
  };
  for (const LoopClosure& loop : mission.loops) {
    for (size_t i = 0; i < loop.p_from.size(); ++i) {
      add(loop.from, loop.p_from[i]);
      add(loop.to, loop.p_to[i]);
    }
  }
  return vertices;
}

double gap_mm(const BentMission& mission, const Mover& mover) {
  const std::vector<SliceVertex> pairs = moved(mover, sightings(mission));
  double sum = 0;
  for (size_t i = 0; i < pairs.size(); i += 2)
    sum += static_cast<double>(squared_norm(pairs[i].p_odom - pairs[i + 1].p_odom));
  return pairs.empty() ? 0 : 1e3 * std::sqrt(2 * sum / static_cast<double>(pairs.size()));
}

Accuracy accuracy(const BentMission& mission, const Mover& mover) {
  constexpr uint32_t kSeamFrames = 15;
  const std::vector<SliceVertex> vertices = moved(mover, mission.vertices);
  std::vector<SliceVertex> later = mission.vertices;
  for (SliceVertex& vertex : later) vertex.pose_sequence += kSeamFrames;
  later = moved(mover, std::move(later));
  Accuracy result;
  std::vector<double> errors, seams;
  for (size_t i = 0; i < vertices.size(); ++i) {
    errors.push_back(1e3 * (to_eigen(vertices[i].p_odom) - mission.true_points[i]).norm());
    seams.push_back(1e3 * static_cast<double>(norm(vertices[i].p_odom - later[i].p_odom)));
    result.mean_mm += errors.back() / static_cast<double>(vertices.size());
  }
  result.p95_mm = p95(std::move(errors));
  result.seam_mm = p95(std::move(seams));
  result.gap_mm = gap_mm(mission, mover);
  return result;
}

void print_row(const char* path, const std::string& name, const DeformationReport& report,
               const Accuracy& accuracy, double time_s) {
  std::printf("| %s | %s | %d | %d | %.1f | %.1f | %.1f | %.1f | %.1f | %.2f |\n", path, name.c_str(),
              report.nodes, report.iterations, accuracy.mean_mm, accuracy.p95_mm, accuracy.seam_mm,
              accuracy.gap_mm, 100 * report.largest_stretch, time_s);
}

void run(const char* path, const BentMission& mission, const Variant& variant) {
  const auto start = std::chrono::steady_clock::now();
  DeformationGraph graph = build_deformation_graph(mission.before, mission.after, variant.config);
  if (variant.start == Start::kIdentity) {
    for (DeformationNode& node : graph.nodes) node.R.setIdentity(), node.t.setZero();
  }
  std::vector<PointConstraint> constraints;
  if (variant.terms != Terms::kNone)
    constraints = camera_constraints(mission.before, mission.after, variant.config);
  if (variant.terms == Terms::kCamerasAndSurface) {
    const auto surface = surface_constraints(mission.before, mission.after, mission.loops);
    constraints.insert(constraints.end(), surface.begin(), surface.end());
  }
  DeformationReport report;
  report.nodes = static_cast<int>(graph.nodes.size());
  if (variant.terms != Terms::kNone) report = solve(graph, constraints);
  const double time_s = seconds_since(start);
  print_row(path, variant.name, report,
            accuracy(mission, [&](std::span<SliceVertex> vertices) { deform(graph, vertices); }), time_s);
}

DeformationConfig config_of(double spacing_m, int look_back, double ahead_m, double arm_m) {
  DeformationConfig config;
  config.node_spacing_m = spacing_m;
  config.look_back = look_back;
  config.node_ahead_m = ahead_m;
  config.camera_arm_m = arm_m;
  return config;
}

std::vector<Variant> variants() {
  const DeformationConfig paper = config_of(0.8, 20, 0, 0);
  return {
      {"paper, from identity", paper, Terms::kCameras, Start::kIdentity},
      {"paper", paper},
      {"paper, surface", paper, Terms::kCamerasAndSurface},
      {"paper with arm", config_of(0.8, 20, 0, 1)},
      {"here, start only", {}, Terms::kNone},
      {"here, from identity", {}, Terms::kCameras, Start::kIdentity},
      {"here", {}},
      {"here, surface", {}, Terms::kCamerasAndSurface},
      {"here without arm", config_of(0.4, 10, 1.5, 0)},
      {"0.8 m", config_of(0.8, 5, 1.5, 1)},
      {"0.2 m", config_of(0.2, 20, 1.5, 1)},
      {"0.1 m", config_of(0.1, 40, 1.5, 1)},
      {"in the camera", config_of(0.4, 10, 0, 1)},
      {"1 m ahead", config_of(0.4, 10, 1, 1)},
      {"2 m ahead", config_of(0.4, 10, 2, 1)},
      {"looks back 8 m", config_of(0.4, 20, 1.5, 1)},
      {"looks back 16 m", config_of(0.4, 40, 1.5, 1)},
  };
}

void print_accuracy() {
  std::printf(
      "| path | graph | nodes | iterations | mean mm | 95 %% mm | seam mm | gap mm | stretch %% | s |\n");
  std::printf("|---|---|---|---|---|---|---|---|---|---|\n");
  constexpr std::pair<BentPath, const char*> kPaths[] = {
      {BentPath::kRing, "ring"}, {BentPath::kCorridor, "corridor"}, {BentPath::kTurns, "turns"}};
  for (const auto& [path, name] : kPaths) {
    BentMissionOptions options;
    options.path = path;
    const BentMission mission = make_bent_mission(options);
    print_row(name, "odometry", {}, accuracy(mission, [](std::span<SliceVertex>) {}), 0);
    print_row(
        name, "own pose", {},
        accuracy(mission, [&](std::span<SliceVertex> vertices) { move_by_own_pose(mission, vertices); }), 0);
    for (const Variant& variant : variants()) run(name, mission, variant);
  }
}

void print_speed() {
  constexpr size_t kVertices = 10'000'000;
  const BentMission mission = make_bent_mission({});
  const DeformationGraph graph = build_deformation_graph(mission.before, mission.after);
  std::vector<SliceVertex> vertices(kVertices);
  for (const int threads : {1, 2}) {
    for (size_t i = 0; i < kVertices; ++i) vertices[i] = mission.vertices[i % mission.vertices.size()];
    const auto start = std::chrono::steady_clock::now();
    deform(graph, vertices, threads);
    std::printf("%d threads: 10 million vertices in %.2f s\n", threads, seconds_since(start));
  }
}

// Half a kilometre straight on, bent by a full turn.
void print_long_mission() {
  constexpr int kFrames = 25'000;
  constexpr double kStep_m = 0.02, kTurn_rad = 2 * std::numbers::pi / kFrames;
  Trajectory before(kFrames);
  std::vector<Pose> after(kFrames, Pose::Identity());
  for (int i = 0; i < kFrames; ++i) {
    const auto k = static_cast<size_t>(i);
    before[k].sequence = i;
    before[k].T_odom_camera.translation().z() = kStep_m * i;
    if (i == 0) continue;
    after[k].linear() = exp_so3({0, kTurn_rad * i, 0});
    after[k].translation() = after[k - 1] * Eigen::Vector3d(0, 0, kStep_m);
  }
  const auto start = std::chrono::steady_clock::now();
  DeformationGraph graph = build_deformation_graph(before, after);
  const DeformationReport report = solve(graph, camera_constraints(before, after, {}));
  std::printf("500 m: %d nodes, %d constraints, %d iterations in %.2f s\n", report.nodes, report.constraints,
              report.iterations, seconds_since(start));
}

}  // namespace
}  // namespace kt::bench

int main() {
  kt::bench::print_accuracy();
  kt::bench::print_speed();
  kt::bench::print_long_mission();
}
