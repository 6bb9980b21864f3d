// Collects the messages of a log into a Session.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/session/load_session.h"

#include <optional>
#include <string>
#include <utility>
#include <variant>

#include "offboard/session/integrity_report.h"
#include "shared/core/check.h"
#include "shared/wire/message_reader.h"

namespace kt {
namespace {

// Takes the messages one by one; a log needs no order but that of each channel.
struct Gatherer {
  const std::filesystem::path& path;
  Session session{};
  bool has_header = false;
  int64_t strays = 0;  // poses and keyframes that do not advance

  void operator()(SessionHeader&& header) {
    if (has_header) throw Error(path.string() + " holds several sessions: a log must hold one mission");
    check_format_version(header, path.string());
    session.header = std::move(header);
    has_header = true;
  }
  // The map needs nothing of the header, so its loss costs no map.
  void make_up_header(const LogIntegrity& integrity) {
    if (session.trajectory.empty() && session.slices.empty()) {
      throw Error(path.string() + " holds no session event, no poses and no slices, so it is no mission (" +
                  integrity_text(integrity) + ")");
    }
    session.header.program_version = session.header.calibration.name = "unknown";
    if (!session.trajectory.empty()) session.header.timestamp_us = session.trajectory.front().timestamp_us;
  }
  template <typename T>
  void add_next(T&& next, std::vector<T>& all) {
    if (all.empty() || all.back().sequence < next.sequence) {
      all.push_back(std::move(next));
    } else {
      ++strays;
    }
  }
  void operator()(StampedPose&& pose) { add_next(std::move(pose), session.trajectory); }
  void operator()(CloudSlice&& slice) {
    if (!session.slices.empty() && slice.voxel_size_m != session.slices.front().voxel_size_m) {
      throw Error(path.string() + ": its slices differ in voxel size, so they are not of one mission");
    }
    session.slices.push_back(SliceInfo::of(slice));
  }
  void operator()(Keyframe&& keyframe) { add_next(std::move(keyframe), session.keyframes); }
  void operator()(LoopClosure&& loop) { session.loop_closures.push_back(std::move(loop)); }
  void operator()(MissionStatus&& status) { session.last_status = status; }
  void operator()(CompressedFrame&&) {}
  void operator()(MotionSample&&) {}
  void operator()(LoadReport&&) {}
  void operator()(BodyPose&&) {}
};

// What the gatherer has, once it has all.
Session session_of(Gatherer&& gatherer, const LogIntegrity& of_log) {
  LogIntegrity& integrity = gatherer.session.integrity;
  integrity = of_log;
  integrity.events -= gatherer.strays;
  integrity.damaged_events += gatherer.strays;
  if (!gatherer.has_header) gatherer.make_up_header(integrity);
  return std::move(gatherer.session);
}

void give(Gatherer& gatherer, Message&& message) {
  std::visit([&gatherer](auto&& m) { gatherer(std::move(m)); }, std::move(message));
}

}  // namespace

Session load_session(const std::filesystem::path& path, const Progress& progress, LogIndex* index) {
  MessageReader reader(path);
  reader.skip<CompressedFrame>();
  reader.skip<MotionSample>();
  reader.skip<LoadReport>();
  reader.skip<BodyPose>();
  Gatherer gatherer{path};
  LogIndex found;
  while (std::optional<Message> message = reader.next()) {
    if (!std::holds_alternative<CloudSlice>(*message)) found.positions.push_back(reader.event_position());
    give(gatherer, std::move(*message));
    if (progress) progress(static_cast<double>(reader.position()) / static_cast<double>(reader.size()));
  }
  found.integrity = reader.integrity();
  found.slices = gatherer.session.slices;
  found.raw_frames = reader.channels()[message_index<CompressedFrame>()].messages;
  Session session = session_of(std::move(gatherer), found.integrity);
  if (index) *index = std::move(found);
  return session;
}

Session load_session(const std::filesystem::path& path, const LogIndex& index, const Progress& progress) {
  MessageReader reader(path);
  Gatherer gatherer{path};
  gatherer.session.slices = index.slices;
  for (size_t i = 0; i < index.positions.size(); ++i) {
    reader.seek(index.positions[i]);
    std::optional<Message> message = reader.next();
    if (!message || reader.event_position() != index.positions[i])
      throw Error(path.string() + " has changed since it was loaded first: load it anew");
    give(gatherer, std::move(*message));
    if (progress) progress(static_cast<double>(i + 1) / static_cast<double>(index.positions.size()));
  }
  return session_of(std::move(gatherer), index.integrity);
}

}  // namespace kt
