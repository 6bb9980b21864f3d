// Numbers on from mission to mission.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/session/join_sessions.h"

#include <algorithm>
#include <iterator>
#include <optional>
#include <string>
#include <utility>
#include <variant>

#include "shared/core/check.h"
#include "shared/wire/message_reader.h"

namespace kt {
namespace {

template <typename T>
void append(std::vector<T>& to, std::vector<T>&& more) {
  std::move(more.begin(), more.end(), std::back_inserter(to));
}

// The first numbers that a mission does not use.
Renumbering behind(const Session& session) {
  Renumbering ends;
  const auto after = [](auto& end, auto number) { end = std::max(end, number + 1); };
  for (const StampedPose& pose : session.trajectory) {
    after(ends.sequence, pose.sequence);
    after(ends.segment, pose.segment);
  }
  for (const Keyframe& keyframe : session.keyframes) {
    after(ends.sequence, keyframe.sequence);
    after(ends.segment, keyframe.segment);
  }
  for (const SliceInfo& slice : session.slices) {
    after(ends.slice, slice.sequence);
    after(ends.segment, slice.segment);
  }
  for (const LoopClosure& closure : session.loop_closures) after(ends.loop, closure.sequence);
  return ends;
}

void renumber(Session& session, const Renumbering& by) {
  for (StampedPose& pose : session.trajectory) {
    pose.sequence += by.sequence;
    pose.from_sequence += by.sequence;
    pose.segment += by.segment;
  }
  for (Keyframe& keyframe : session.keyframes) {
    keyframe.sequence += by.sequence;
    keyframe.segment += by.segment;
  }
  for (SliceInfo& slice : session.slices) {
    slice.sequence += by.slice;
    slice.segment += by.segment;
  }
  for (LoopClosure& loop : session.loop_closures) {
    loop.sequence += by.loop;
    loop.from += by.sequence;
    loop.to += by.sequence;
  }
}

void check_alike(const Session& first, const Session& other, size_t number) {
  const std::string which = "log " + std::to_string(number + 1);
  if (!first.header.calibration.is_equal_to(other.header.calibration)) {
    throw Error(which + " was recorded with another calibration (" + other.header.calibration.name +
                ") than the first (" + first.header.calibration.name +
                "): only logs of one camera can be joined");
  }
  if (!first.slices.empty() && !other.slices.empty() &&
      first.slices.front().voxel_size_m != other.slices.front().voxel_size_m)
    throw Error(which + " has another voxel size than the first: record both with one volume.voxel_size_m");
}

}  // namespace

JoinedSession join_sessions(std::vector<Session> sessions) {
  KT_CHECK(!sessions.empty());
  JoinedSession joined{std::move(sessions.front()), {{}}};
  Session& all = joined.session;
  for (size_t i = 1; i < sessions.size(); ++i) {
    Session& next = sessions[i];
    check_alike(all, next, i);
    joined.missions.push_back(behind(all));
    renumber(next, joined.missions.back());
    append(all.trajectory, std::move(next.trajectory));
    append(all.keyframes, std::move(next.keyframes));
    append(all.slices, std::move(next.slices));
    append(all.loop_closures, std::move(next.loop_closures));
    all.last_status.frames_skipped += next.last_status.frames_skipped;
    const LogIntegrity& more = next.integrity;
    all.integrity.events += more.events;
    all.integrity.unknown_events += more.unknown_events;
    all.integrity.damaged_events += more.damaged_events;
    all.integrity.skipped_bytes += more.skipped_bytes;
    all.integrity.missing_messages += more.missing_messages;
    all.integrity.missing_parts += more.missing_parts;
    all.integrity.truncated |= more.truncated;
    all.integrity.session_missing |= more.session_missing;
    all.integrity.final_slice_missing |= more.final_slice_missing;
  }
  return joined;
}

void load_slices(std::span<const MissionLog> logs, const std::function<void(CloudSlice&&)>& take) {
  for (const MissionLog& log : logs) {
    MessageReader reader(log.path);
    reader.skip<StampedPose>();
    reader.skip<Keyframe>();
    reader.skip<LoopClosure>();
    reader.skip<CompressedFrame>();
    reader.skip<MotionSample>();
    reader.skip<LoadReport>();
    reader.skip<BodyPose>();
    while (std::optional<Message> message = reader.next()) {
      auto* slice = std::get_if<CloudSlice>(&*message);
      if (slice == nullptr) continue;
      slice->sequence += log.numbers.slice;
      slice->segment += log.numbers.segment;
      for (SliceVertex& vertex : slice->vertices)
        vertex.pose_sequence += static_cast<uint32_t>(log.numbers.sequence);
      take(std::move(*slice));
    }
  }
}

}  // namespace kt
