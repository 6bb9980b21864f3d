// Counts a log and words the result.
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/log/info.h"

#include <algorithm>
#include <set>
#include <variant>

#include "nlohmann/json.hpp"

#include "offboard/session/integrity_report.h"
#include "shared/core/formatted.h"
#include "shared/io/text_lines.h"

namespace kt {
namespace {

constexpr TrackingStatus kStatuses[] = {TrackingStatus::kGood, TrackingStatus::kUncertain,
                                        TrackingStatus::kLost};

double seconds(int64_t from_us, int64_t to_us) { return static_cast<double>(to_us - from_us) * 1e-6; }

// Messages per second of sensor time; 0 where there are too few to tell.
double rate_hz(const MessageReader::ChannelCount& channel) {
  const double duration_s = seconds(channel.first_us, channel.last_us);
  return channel.messages > 1 && duration_s > 0 ? static_cast<double>(channel.messages - 1) / duration_s : 0;
}

std::string size_text(int64_t bytes) {
  const auto size = static_cast<double>(bytes);
  if (size < 1e3) return formatted("%.0f B", size);
  if (size < 1e6) return formatted("%.1f kB", size / 1e3);
  return size < 1e9 ? formatted("%.1f MB", size / 1e6) : formatted("%.2f GB", size / 1e9);
}

std::string camera_text(const Camera& camera) {
  return formatted("%d x %d, f %.2f %.2f, c %.2f %.2f%s", camera.width, camera.height, camera.fx, camera.fy,
                   camera.cx, camera.cy, camera.is_distorted() ? ", distorted" : "");
}

std::string session_text(const SessionHeader& session) {
  const Calibration& calibration = session.calibration;
  return formatted("written by   Kintsugi %s, log format %d\n", session.program_version.c_str(),
                   session.format_version) +
         formatted("calibration  %s, depth unit %g m%s\n", calibration.name.c_str(), calibration.depth_unit_m,
                   calibration.is_registered() ? ", colour registered to depth" : "") +
         formatted("  depth      %s\n  colour     %s\n", camera_text(calibration.depth).c_str(),
                   camera_text(calibration.colour).c_str());
}

std::string indented(const std::string& text) {
  std::string result = "  ";
  for (const char c : text) {
    result += c;
    if (c == '\n') result += "  ";
  }
  result.erase(result.find_last_not_of(" \n") + 1);
  return result;
}

}  // namespace

LogInfo read_info(const std::filesystem::path& path) {
  MessageReader reader(path);
  LogInfo info;
  std::set<int> segments;
  info.path = path;
  info.file_bytes = reader.size();
  info.parts = reader.parts();
  while (std::optional<Message> message = reader.next()) {
    if (auto* session = std::get_if<SessionHeader>(&*message)) {
      if (!info.session) info.session = std::move(*session);
    } else if (const auto* pose = std::get_if<StampedPose>(&*message)) {
      ++info.poses_by_status[static_cast<size_t>(pose->status)];
      segments.insert(pose->segment);
    } else if (const auto* slice = std::get_if<CloudSlice>(&*message)) {
      info.slice_vertices += static_cast<int64_t>(slice->vertices.size());
      info.slice_triangles += static_cast<int64_t>(slice->triangles.size());
    }
  }
  info.segments = static_cast<int64_t>(segments.size());
  info.channels = reader.channels();
  info.integrity = reader.integrity();
  bool first = true;
  for (const auto& channel : info.channels) {
    if (channel.messages == 0) continue;
    info.first_us = first ? channel.first_us : std::min(info.first_us, channel.first_us);
    info.last_us = first ? channel.last_us : std::max(info.last_us, channel.last_us);
    first = false;
  }
  return info;
}

std::string info_text(const LogInfo& info) {
  std::string text = formatted("log          %s, %s", info.path.c_str(), size_text(info.file_bytes).c_str());
  if (info.parts > 1) text += formatted(" in %lld files", static_cast<long long>(info.parts));
  text += "\n";
  text += info.session ? session_text(*info.session) : "written by   unknown: there is no session event\n";
  text += formatted("recorded     %.2f s from stamp %s\n", seconds(info.first_us, info.last_us),
                    format_stamp_us(info.first_us).c_str());
  text += formatted("integrity    %s\n", integrity_text(info.integrity).c_str());
  text += "poses       ";
  for (const TrackingStatus status : kStatuses) {
    text += formatted(" %lld %s", static_cast<long long>(info.poses_by_status[static_cast<size_t>(status)]),
                      to_string(status));
  }
  if (info.segments > 1) text += formatted(", in %lld segments", static_cast<long long>(info.segments));
  text +=
      formatted("\nslices       %lld vertices, %lld triangles\n\n",
                static_cast<long long>(info.slice_vertices), static_cast<long long>(info.slice_triangles));
  text += formatted("%-18s %9s %9s %10s %8s\n", "channel", "messages", "per s", "size", "missing");
  for (size_t i = 0; i < kChannels.size(); ++i) {
    const auto& channel = info.channels[i];
    if (channel.messages == 0) continue;
    text += formatted("%-18s %9lld %9.2f %10s %8lld\n", kChannels[i].data(),
                      static_cast<long long>(channel.messages), rate_hz(channel),
                      size_text(channel.bytes).c_str(), static_cast<long long>(channel.missing));
  }
  if (info.session && !info.session->configuration_yaml.empty()) {
    text += "\nconfiguration\n" + indented(info.session->configuration_yaml) + "\n";
  }
  return text;
}

std::string info_json(const LogInfo& info) {
  using Json = nlohmann::ordered_json;
  const auto camera_json = [](const Camera& camera) {
    return Json{{"width", camera.width},
                {"height", camera.height},
                {"fx", camera.fx},
                {"fy", camera.fy},
                {"cx", camera.cx},
                {"cy", camera.cy},
                {"distortion", camera.distortion}};
  };
  Json json = {
      {"log", info.path.string()}, {"bytes", info.file_bytes}, {"files", info.parts}, {"session", nullptr}};
  if (info.session) {
    const SessionHeader& session = *info.session;
    json["session"] = {{"program_version", session.program_version},
                       {"format_version", session.format_version},
                       {"calibration",
                        {{"name", session.calibration.name},
                         {"depth", camera_json(session.calibration.depth)},
                         {"colour", camera_json(session.calibration.colour)},
                         {"depth_unit_m", session.calibration.depth_unit_m}}},
                       {"configuration_yaml", session.configuration_yaml}};
  }
  json["first_us"] = info.first_us;
  json["duration_s"] = seconds(info.first_us, info.last_us);
  json["integrity"] = integrity_json(info.integrity);
  for (const TrackingStatus status : kStatuses) {
    json["poses"][to_string(status)] = info.poses_by_status[static_cast<size_t>(status)];
  }
  json["segments"] = info.segments;
  json["slices"] = {{"vertices", info.slice_vertices}, {"triangles", info.slice_triangles}};
  for (size_t i = 0; i < kChannels.size(); ++i) {
    const auto& channel = info.channels[i];
    json["channels"][kChannels[i].data()] = {{"messages", channel.messages},
                                             {"rate_hz", rate_hz(channel)},
                                             {"bytes", channel.bytes},
                                             {"missing", channel.missing}};
  }
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace kt
