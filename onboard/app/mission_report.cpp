// Formats a mission's summary.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/app/mission_report.h"

#include <cstdio>
#include <fstream>

#include "nlohmann/json.hpp"

#include "shared/core/version.h"

namespace kt {
namespace {

double tracked_share(const MissionStatus& status) {
  return status.frames > 0 ? static_cast<double>(status.frames_good) / static_cast<double>(status.frames) : 0;
}

template <typename... Values>
std::string format(const char* pattern, Values... values) {
  char line[256];
  std::snprintf(line, sizeof(line), pattern, values...);
  return line;
}

nlohmann::ordered_json to_json(const StageTimes& times) {
  return {
      {"p50_ms", times.p50_ms}, {"p95_ms", times.p95_ms}, {"max_ms", times.max_ms}, {"count", times.count}};
}

}  // namespace

std::string mission_report_text(const MissionSummary& summary) {
  const MissionStatus& s = summary.status;
  std::string text = format(
      "frames    %lld processed, %.1f %% tracked (%lld uncertain, %lld lost), %lld skipped\n",
      static_cast<long long>(s.frames), 100 * tracked_share(s), static_cast<long long>(s.frames_uncertain),
      static_cast<long long>(s.frames_lost), static_cast<long long>(s.frames_skipped));
  for (const std::string& reason : summary.skip_reasons) text += "  skipped: " + reason + "\n";
  if (summary.motion_samples + summary.motion_samples_refused > 0) {
    text += format("motion    %lld samples of other sensors, %lld refused\n",
                   static_cast<long long>(summary.motion_samples),
                   static_cast<long long>(summary.motion_samples_refused));
  }
  for (const std::string& reason : summary.motion_refusals) text += "  refused: " + reason + "\n";
  text += format("slices    %lld with %lld vertices, %lld triangles\n", static_cast<long long>(s.slices),
                 static_cast<long long>(s.slice_vertices), static_cast<long long>(s.slice_triangles));
  text += format("%-10s%10s%10s%10s\n", "stage", "p50 ms", "p95 ms", "max ms");
  for (const auto& [stage, times] : summary.stage_times) {
    text += format("%-10s%10.2f%10.2f%10.2f\n", stage.c_str(), times.p50_ms, times.p95_ms, times.max_ms);
  }
  text += format("took      %.1f s, %.0f MiB of memory at most%s\n", summary.seconds, summary.peak_memory_mib,
                 summary.interrupted ? "; stopped by the user" : "");
  return text;
}

void write_mission_report(const MissionSummary& summary, const std::filesystem::path& path) {
  const MissionStatus& s = summary.status;
  nlohmann::ordered_json stages;
  for (const auto& [stage, times] : summary.stage_times) {
    if (stage != "frame") stages[stage] = to_json(times);
  }
  const auto whole_frame = summary.stage_times.find("frame");
  nlohmann::ordered_json report = {
      {"program_version", kProgramVersion},
      {"frames", s.frames},
      {"tracked_share", tracked_share(s)},
      {"frames_uncertain", s.frames_uncertain},
      {"frames_lost", s.frames_lost},
      {"frames_skipped", s.frames_skipped},
      {"skip_reasons", summary.skip_reasons},
      {"slices", s.slices},
      {"vertices", s.slice_vertices},
      {"triangles", s.slice_triangles},
      {"process", whole_frame == summary.stage_times.end() ? to_json({}) : to_json(whole_frame->second)},
      {"stages", stages},
      {"seconds", summary.seconds},
      {"peak_memory_mb", summary.peak_memory_mib},
      {"interrupted", summary.interrupted},
  };
  if (summary.motion_samples + summary.motion_samples_refused > 0) {
    report["motion_samples"] = summary.motion_samples;
    report["motion_samples_refused"] = summary.motion_samples_refused;
    report["motion_refusals"] = summary.motion_refusals;
  }
  std::ofstream file(path);
  file << report.dump(2) << '\n';
  if (!file.flush())
    throw Error("cannot write " + path.string() + ": is the folder there and the disk not full?");
}

}  // namespace kt
