// kintsugi-match: takes pairs of frames through the tests of a loop candidate, and says what became of each.
// SPDX-License-Identifier: BSD-3-Clause
#include <map>
#include <numbers>

#include "offboard/session/load_session.h"
#include "shared/cli/program.h"
#include "tools/eval/groundtruth.h"
#include "tools/match/frames_command.h"
#include "tools/match/orbit.h"
#include "tools/match/pair_report.h"

namespace kt {
namespace {

struct OrbitCommand {
  std::string mission, feature = "surf";
  std::vector<double> degrees = {0, 5, 10, 15, 20, 25, 30, 35, 40, 45, 50, 55, 60};
  int64_t every = 40;
  double ahead_m = 2;

  void add_to(CLI::App& app) {
    app.add_option("mission", mission, "synthetic mission whose world is looked at")->required();
    app.add_option("--degrees", degrees, "angles that the camera is led around")->expected(1, 100);
    app.add_option("--ahead", ahead_m, "distance of the point that it is led around (m)")
        ->capture_default_str();
    app.add_option("--every", every, "frames from one place to the next")
        ->check(CLI::PositiveNumber)
        ->capture_default_str();
    app.add_option("--feature", feature, "surf or corners")
        ->check(CLI::IsMember({"surf", "corners"}))
        ->capture_default_str();
  }

  void run() const {
    const SyntheticMission world(mission);
    Stopwatch watch;
    PlaceMaker maker(world.calibration(), feature, &watch);
    Json rows = Json::array();
    int64_t number = 0;
    for (int64_t i = 0; i < world.frame_count(); i += every) {
      const Pose T_world_from = world.groundtruth()[static_cast<size_t>(i)].T_odom_camera;
      const double side = i / every % 2 == 0 ? 1 : -1;
      const KnownPlace from = maker.make(render_at(world, T_world_from, number++));
      for (const double angle : degrees) {
        const Pose T_world_to = orbited(T_world_from, ahead_m, side * angle * std::numbers::pi / 180);
        if (!stands_free(world, T_world_to)) continue;
        const KnownPlace to = maker.make(render_at(world, T_world_to, number++));
        Json row = pair_json(maker.compare(from, to, T_world_from.inverse() * T_world_to));
        row["place"] = i;
        row["disturbance"] = "viewpoint";
        row["level"] = angle;
        rows.push_back(std::move(row));
      }
    }
    print({{"source", "synthetic:" + mission}, {"feature", feature}}, watch, rows);
  }
};

struct LogCommand {
  std::string log, groundtruth;
  bool all = false;

  void add_to(CLI::App& app) {
    app.add_option("log", log, "a mission's log")->required();
    app.add_option("--groundtruth", groundtruth, "as kintsugi-eval takes it");
    app.add_flag("--all", all, "rejected candidates too");
  }

  void run() const {
    const Session session = load_session(log);
    if (session.keyframes.empty()) throw Error(log + " holds no keyframes");
    PairComparer comparer(session.header.calibration, session.keyframes.front().descriptor_type);
    std::vector<int64_t> stamps_us;
    for (const Keyframe& keyframe : session.keyframes) stamps_us.push_back(keyframe.timestamp_us);
    std::vector<std::optional<Pose>> truth(stamps_us.size());
    if (!groundtruth.empty()) truth = poses_at(read_groundtruth(groundtruth), stamps_us);
    std::map<int64_t, std::pair<KnownPlace, std::optional<Pose>>> places;
    for (size_t k = 0; k < stamps_us.size(); ++k)
      places[session.keyframes[k].sequence] = {comparer.known(session.keyframes[k]), truth[k]};
    Json rows = Json::array();
    Stopwatch watch;
    for (const LoopClosure& loop : session.loop_closures) {
      const auto from = places.find(loop.from), to = places.find(loop.to);
      if ((!all && !loop.accepted()) || from == places.end() || to == places.end()) continue;
      std::optional<Pose> T_from_to;
      if (from->second.second && to->second.second)
        T_from_to = from->second.second->inverse() * *to->second.second;
      const PairComparison pair = comparer.compare(from->second.first, to->second.first, T_from_to);
      watch.add("verification", pair.verification_ms);
      rows.push_back(pair_json(pair));
    }
    print({{"source", log}, {"feature", comparer.vocabulary().kind().type}}, watch, rows);
  }
};

}  // namespace
}  // namespace kt

int main(int argc, char** argv) {
  CLI::App app("Takes pairs of frames through the tests of a loop candidate; prints JSON.", "kintsugi-match");
  app.require_subcommand(1);
  kt::FramesCommand frames;
  kt::OrbitCommand orbit;
  kt::LogCommand log;
  CLI::App* frames_app =
      app.add_subcommand("frames", "pairs of a recording, the later frame disturbed where asked");
  CLI::App* orbit_app = app.add_subcommand("orbit", "views of a synthetic world around a point");
  CLI::App* log_app =
      app.add_subcommand("log", "the accepted candidates of a log, once more from its keyframes");
  frames.add_to(*frames_app);
  orbit.add_to(*orbit_app);
  log.add_to(*log_app);
  return kt::run_program(app, argc, argv, [&] {
    if (frames_app->parsed()) frames.run();
    if (orbit_app->parsed()) orbit.run();
    if (log_app->parsed()) log.run();
  });
}
