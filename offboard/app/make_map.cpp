// Load, weld, write; segment by segment.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/app/make_map.h"

#include <chrono>
#include <sys/resource.h>
#include <utility>

#include "offboard/app/segment_folders.h"
#include "offboard/map/weld.h"
#include "offboard/report/map_report.h"
#include "offboard/session/integrity_report.h"
#include "offboard/session/load_session.h"
#include "offboard/session/segments.h"
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

// Slices are welded within their segment only. What has neither good frames nor surface is not written.
std::vector<SegmentMap> weld_each(std::vector<Segment> segments, size_t main) {
  std::vector<SegmentMap> maps;
  for (Segment& segment : segments) {
    Mesh map = weld(segment.slices);
    std::string folder;
    if (maps.size() == main) {
      folder = ".";
    } else if (segment.good_frames() > 0 || !map.triangles.empty()) {
      folder = segment_folder(segment.number);
    }
    maps.push_back({std::move(segment), std::move(map), std::move(folder)});
  }
  return maps;
}

std::string size_text(const Mesh& map) {
  return std::to_string(map.vertices.size()) + " vertices, " + std::to_string(map.triangles.size()) +
         " triangles";
}

// A line for each where there are several.
std::string segments_text(const std::vector<SegmentMap>& maps) {
  if (maps.size() == 1) return {};
  std::string text =
      std::to_string(maps.size()) + " segments, not joined: how they stand to each other is not known\n";
  for (const auto& [segment, map, folder] : maps) {
    text += "  segment " + std::to_string(segment.number) + ": " + std::to_string(segment.trajectory.size()) +
            " poses, " + std::to_string(segment.good_frames()) + " good, " + size_text(map) + "; ";
    text += (folder.empty() ? "not written" : "in " + folder) + "\n";
  }
  return text;
}

std::string summary(const Session& session, const std::vector<SegmentMap>& maps, size_t main,
                    const MapOptions& options) {
  return "log:  " + integrity_text(session.integrity) + "\nmap:  " + size_text(maps[main].map) + " from " +
         std::to_string(maps[main].segment.slices.size()) +
         " slices\npath: " + std::to_string(maps[main].segment.trajectory.size()) + " poses\nwritten to " +
         options.output.string() + ": map.ply, trajectory.txt, poses.g2o, report.json\n" +
         segments_text(maps);
}

}  // namespace

std::string make_map(const MapOptions& options, const StepProgress& progress) {
  Steps steps(progress);
  Session session = steps.run("load", [&](const auto& tell) { return load_session(options.log, tell); });
  if (session.trajectory.empty()) {
    throw Error(options.log.string() +
                " holds no poses, so it is no mission: where it holds raw frames, run kintsugi-collect " +
                "--input lcm-log:" + options.log.string() + " first");
  }
  create_folder(options.output);
  std::vector<Segment> segments = take_segments(session);
  const size_t main = main_segment(segments);
  const std::vector<SegmentMap> maps =
      steps.run("weld", [&](const auto&) { return weld_each(std::move(segments), main); });
  steps.run("write", [&](const auto& tell) {
    remove_segment_folders(options.output);
    for (size_t i = 0; i < maps.size(); ++i) {
      if (!maps[i].folder.empty()) write_segment(options.output, maps[i], session.loop_closures);
      tell(static_cast<double>(i + 1) / static_cast<double>(maps.size()));
    }
    return true;
  });
  const RunFigures run{options.log.string(), steps.times_s(), peak_memory_bytes()};
  write_file(options.output / "report.json", map_report(session, maps, main, run));
  return summary(session, maps, main, options);
}

}  // namespace kt
