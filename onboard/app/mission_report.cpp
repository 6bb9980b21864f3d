// Formats a mission's summary.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/app/mission_report.h"

#include <algorithm>
#include <fstream>

#include "nlohmann/json.hpp"

#include "shared/core/formatted.h"
#include "shared/core/version.h"

namespace kt {
namespace {

double tracked_share(const MissionStatus& status) {
  return status.frames > 0 ? static_cast<double>(status.frames_good) / static_cast<double>(status.frames) : 0;
}

// "990 model, 6 features"
std::string sources_text(const MissionStatus& status) {
  std::string text;
  for (size_t i = 0; i < status.frames_by_source.size(); ++i) {
    if (status.frames_by_source[i] == 0) continue;
    text += (text.empty() ? "" : ", ") + std::to_string(status.frames_by_source[i]) + " " +
            to_string(static_cast<PoseSource>(i));
  }
  return text;
}

// "12.3 s to 13.4 s (frames 370 to 402): 20 lost, 13 uncertain, few inliers; found again by features"
std::string stretch_text(const TrackingStretch& stretch, const MissionSummary& summary) {
  const auto seconds = [](int64_t us) { return static_cast<double>(us) * 1e-6; };
  std::string text =
      formatted("%.1f s to %.1f s (frames %lld to %lld): ", seconds(stretch.first_us - summary.first_us),
                seconds(stretch.last_us - summary.first_us), static_cast<long long>(stretch.first_sequence),
                static_cast<long long>(stretch.last_sequence));
  std::string what;
  const auto add = [&what](const std::string& part) { what += (what.empty() ? "" : ", ") + part; };
  if (stretch.gap_us > 0) add(formatted("no frames for %.1f s", seconds(stretch.gap_us)));
  if (stretch.lost > 0) add(std::to_string(stretch.lost) + " lost");
  if (stretch.uncertain > 0) add(std::to_string(stretch.uncertain) + " uncertain");
  if (stretch.cause != TrackingCause::kNone) add(to_string(stretch.cause));
  text += what + "; " + to_string(stretch.end);
  if (stretch.end == TrackingStretch::End::kFound && stretch.found_by != PoseSource::kNone)
    text += std::string(" by ") + to_string(stretch.found_by);
  return text;
}

nlohmann::ordered_json to_json(const TrackingStretch& stretch) {
  using Json = nlohmann::ordered_json;
  const bool is_found = stretch.end == TrackingStretch::End::kFound;
  return {{"first_frame", stretch.first_sequence},
          {"last_frame", stretch.last_sequence},
          {"first_timestamp_us", stretch.first_us},
          {"last_timestamp_us", stretch.last_us},
          {"lost", stretch.lost},
          {"uncertain", stretch.uncertain},
          {"gap_us", stretch.gap_us},
          {"cause", stretch.is_gap ? "gap" : to_string(stretch.cause)},
          {"lowest_inlier_share", stretch.lowest_inlier_share},
          {"end", to_string(stretch.end)},
          {"found_by", is_found ? Json(to_string(stretch.found_by)) : Json(nullptr)}};
}

std::string publishing_text(const LcmSink::Counts& counts) {
  return formatted("published %lld messages, %.1f MB; %lld dropped, %lld refused by the network\n",
                   static_cast<long long>(counts.messages), static_cast<double>(counts.bytes) / 1e6,
                   static_cast<long long>(counts.dropped), static_cast<long long>(counts.refused));
}

// Of a mission that was late; else empty.
std::string effort_text(const MissionSummary& summary) {
  std::string text;
  if (summary.frames_dropped > 0)
    text += formatted("late      %lld frames dropped, of those skipped\n",
                      static_cast<long long>(summary.frames_dropped));
  for (int i = 1; i < kEfforts; ++i) {
    const int64_t frames = summary.frames_by_effort[static_cast<size_t>(i)];
    if (frames == 0) continue;
    text += formatted("late      %lld frames with less work: %s\n", static_cast<long long>(frames),
                      to_string(static_cast<Effort>(i)));
  }
  return text;
}

nlohmann::ordered_json to_json(const LcmSink::Counts& counts) {
  return {{"messages", counts.messages},
          {"bytes", counts.bytes},
          {"dropped", counts.dropped},
          {"refused", counts.refused}};
}

nlohmann::ordered_json to_json(const StageTimes& times) {
  return {
      {"p50_ms", times.p50_ms}, {"p95_ms", times.p95_ms}, {"max_ms", times.max_ms}, {"count", times.count}};
}

}  // namespace

std::string not_stored_text(const StorageState& storage) {
  std::string text;
  const auto add = [&text](int64_t count, const char* one, const char* several) {
    if (count > 0)
      text += (text.empty() ? "" : ", ") + std::to_string(count) + " " + (count == 1 ? one : several);
  };
  add(storage.raw_frames, "raw frame", "raw frames");
  add(storage.motion_samples, "motion sample", "motion samples");
  add(storage.keyframes, "keyframe", "keyframes");
  add(storage.slices, "slice", "slices");
  add(storage.poses, "pose", "poses");
  add(storage.others, "other message", "other messages");
  return text;
}

std::string mission_progress_text(const MissionStatus& status, int64_t frame_count, double seconds) {
  std::string why;
  const auto add = [&why](const std::string& part) { why += (why.empty() ? "" : ", ") + part; };
  if (status.source != PoseSource::kNone && status.source != PoseSource::kModel)
    add(to_string(status.source));
  if (status.cause != TrackingCause::kNone) add(to_string(status.cause));
  if (status.inlier_share > 0) add(formatted("%.0f %%", 100 * status.inlier_share));
  return formatted("frame %lld%s  %.1f Hz  %s%s  %lld slices  %lld skipped",
                   static_cast<long long>(status.frames + status.frames_skipped),
                   frame_count > 0 ? (" of " + std::to_string(frame_count)).c_str() : "",
                   static_cast<double>(status.frames) / std::max(seconds, 1e-3), to_string(status.tracking),
                   why.empty() ? "" : (" (" + why + ")").c_str(), static_cast<long long>(status.slices),
                   static_cast<long long>(status.frames_skipped));
}

std::string mission_report_text(const MissionSummary& summary) {
  const MissionStatus& s = summary.status;
  std::string text = formatted(
      "frames    %lld processed, %.1f %% tracked (%lld uncertain, %lld lost), %lld skipped\n",
      static_cast<long long>(s.frames), 100 * tracked_share(s), static_cast<long long>(s.frames_uncertain),
      static_cast<long long>(s.frames_lost), static_cast<long long>(s.frames_skipped));
  text += effort_text(summary);
  for (const std::string& reason : summary.skip_reasons) text += "  skipped: " + reason + "\n";
  if (summary.camera_losses > 0)
    text +=
        formatted("camera    gone %lld times for a while\n", static_cast<long long>(summary.camera_losses));
  for (const std::string& reason : summary.camera_loss_reasons) text += "  gone: " + reason + "\n";
  if (summary.motion_samples + summary.motion_samples_refused > 0) {
    text += formatted("motion    %lld samples of other sensors, %lld refused\n",
                      static_cast<long long>(summary.motion_samples),
                      static_cast<long long>(summary.motion_samples_refused));
  }
  for (const std::string& reason : summary.motion_refusals) text += "  refused: " + reason + "\n";
  if (s.frames > 0) text += "poses     " + sources_text(s) + "\n";
  if (s.segments > 1)
    text += formatted("segments  %d, counted from 0; at the end in segment %d\n", s.segments, s.segment);
  if (!summary.stretches.empty()) text += "worst stretches of the tracking\n";
  for (const TrackingStretch& stretch : summary.stretches)
    text += "  " + stretch_text(stretch, summary) + "\n";
  const int64_t more = summary.stretch_count - static_cast<int64_t>(summary.stretches.size());
  if (more > 0) text += formatted("  and %lld more, none of them longer\n", static_cast<long long>(more));
  text += formatted("slices    %lld with %lld vertices, %lld triangles\n", static_cast<long long>(s.slices),
                    static_cast<long long>(s.slice_vertices), static_cast<long long>(s.slice_triangles));
  if (summary.storage.not_stored() > 0)
    text += "log       without " + not_stored_text(summary.storage) + ": the disk was low or full\n";
  if (summary.publishing) text += publishing_text(*summary.publishing);
  text += formatted("%-10s%10s%10s%10s\n", "stage", "p50 ms", "p95 ms", "max ms");
  for (const auto& [stage, times] : summary.stage_times) {
    const char* name = stage == "frame_fallback" ? "fallback" : stage.c_str();
    text += formatted("%-10s%10.2f%10.2f%10.2f\n", name, times.p50_ms, times.p95_ms, times.max_ms);
  }
  text +=
      formatted("took      %.1f s, %.0f MiB of memory at most%s\n", summary.seconds, summary.peak_memory_mib,
                summary.interrupted ? "; stopped by the user"
                : summary.timed_out ? "; no more frames came"
                                    : "");
  return text;
}

void write_mission_report(const MissionSummary& summary, const std::filesystem::path& path) {
  const MissionStatus& s = summary.status;
  nlohmann::ordered_json stages;
  for (const auto& [stage, times] : summary.stage_times) {
    if (stage != "frame" && stage != "frame_fallback") stages[stage] = to_json(times);
  }
  const auto times_of = [&summary](const char* stage) {
    const auto found = summary.stage_times.find(stage);
    return to_json(found == summary.stage_times.end() ? StageTimes{} : found->second);
  };
  nlohmann::ordered_json frames_by_effort;
  for (int i = 0; i < kEfforts; ++i)
    frames_by_effort[to_string(static_cast<Effort>(i))] = summary.frames_by_effort[static_cast<size_t>(i)];
  nlohmann::ordered_json poses_by_source, stretches = nlohmann::ordered_json::array();
  for (size_t i = 0; i < s.frames_by_source.size(); ++i)
    poses_by_source[to_string(static_cast<PoseSource>(i))] = s.frames_by_source[i];
  for (const TrackingStretch& stretch : summary.stretches) stretches.push_back(to_json(stretch));
  nlohmann::ordered_json report = {
      {"program_version", kProgramVersion},
      {"device", summary.device},
      {"threads", summary.threads},
      {"frames", s.frames},
      {"tracked_share", tracked_share(s)},
      {"frames_uncertain", s.frames_uncertain},
      {"frames_lost", s.frames_lost},
      {"frames_skipped", s.frames_skipped},
      {"skip_reasons", summary.skip_reasons},
      {"frames_dropped", summary.frames_dropped},
      {"frames_by_effort", frames_by_effort},
      {"poses_by_source", poses_by_source},
      {"segments", s.segments},
      {"segment", s.segment},
      {"stretches", stretches},
      {"stretch_count", summary.stretch_count},
      {"slices", s.slices},
      {"vertices", s.slice_vertices},
      {"triangles", s.slice_triangles},
      {"process", times_of("frame")},
      {"fallback", times_of("frame_fallback")},
      {"stages", stages},
      {"seconds", summary.seconds},
      {"peak_memory_mb", summary.peak_memory_mib},
      {"interrupted", summary.interrupted},
      {"timed_out", summary.timed_out},
  };
  if (const StorageState& storage = summary.storage; storage.not_stored() > 0) {
    report["not_stored"] = {{"raw_frames", storage.raw_frames}, {"motion_samples", storage.motion_samples},
                            {"keyframes", storage.keyframes},   {"slices", storage.slices},
                            {"poses", storage.poses},           {"others", storage.others}};
  }
  if (summary.publishing) report["publishing"] = to_json(*summary.publishing);
  if (summary.camera_losses > 0) {
    report["camera_losses"] = summary.camera_losses;
    report["camera_loss_reasons"] = summary.camera_loss_reasons;
  }
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
