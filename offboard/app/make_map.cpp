// Load, weld, write.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/app/make_map.h"

#include <chrono>
#include <sys/resource.h>
#include <system_error>
#include <utility>

#include "offboard/map/weld.h"
#include "offboard/report/map_report.h"
#include "offboard/report/odometry_graph.h"
#include "offboard/session/integrity_report.h"
#include "offboard/session/load_session.h"
#include "shared/core/check.h"
#include "shared/io/file.h"
#include "shared/io/ply.h"
#include "shared/io/trajectory_file.h"

namespace kt {
namespace {

void create_folder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error || !std::filesystem::is_directory(folder)) {
    throw Error("cannot create the folder " + folder.string() + ": " +
                (error ? error.message() : std::string("a file of that name stands there")));
  }
}

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

std::string summary(const Session& session, const Mesh& map, const MapOptions& options) {
  return "log:  " + integrity_text(session.integrity) + "\nmap:  " + std::to_string(map.vertices.size()) +
         " vertices, " + std::to_string(map.triangles.size()) + " triangles from " +
         std::to_string(session.slices.size()) +
         " slices\npath: " + std::to_string(session.trajectory.size()) + " poses\nwritten to " +
         options.output.string() + ": map.ply, trajectory.txt, poses.g2o, report.json\n";
}

}  // namespace

std::string make_map(const MapOptions& options, const StepProgress& progress) {
  Steps steps(progress);
  const Session session =
      steps.run("load", [&](const auto& tell) { return load_session(options.log, tell); });
  if (session.trajectory.empty()) {
    throw Error(options.log.string() +
                " holds no poses, so it is no mission: where it holds raw frames, run kintsugi-collect " +
                "--input lcm-log:" + options.log.string() + " first");
  }
  create_folder(options.output);
  const Mesh map = steps.run("weld", [&](const auto&) { return weld(session.slices); });
  steps.run("write", [&](const auto& tell) {
    write_ply(options.output / "map.ply", map);
    tell(0.8);
    write_trajectory(options.output / "trajectory.txt", session.trajectory);
    write_g2o(options.output / "poses.g2o", odometry_graph(session));
    return true;
  });
  const RunFigures run{options.log.string(), steps.times_s(), peak_memory_bytes()};
  write_file(options.output / "report.json", map_report(session, map, run));
  return summary(session, map, options);
}

}  // namespace kt
