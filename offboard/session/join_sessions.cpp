// Numbers on from mission to mission.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/session/join_sessions.h"

#include <algorithm>
#include <iterator>
#include <string>
#include <utility>

#include "shared/core/check.h"

namespace kt {
namespace {

template <typename T>
void append(std::vector<T>& to, std::vector<T>&& more) {
  std::move(more.begin(), more.end(), std::back_inserter(to));
}

// The first number that a mission does not use.
struct Ends {
  int64_t sequence = 0, slice = 0, loop = 0;
  int segment = 0;

  explicit Ends(const Session& session) {
    const auto after = [](auto& end, auto number) { end = std::max(end, number + 1); };
    for (const StampedPose& pose : session.trajectory) {
      after(sequence, pose.sequence);
      after(segment, pose.segment);
    }
    for (const Keyframe& keyframe : session.keyframes) {
      after(sequence, keyframe.sequence);
      after(segment, keyframe.segment);
    }
    for (const CloudSlice& one : session.slices) {
      after(slice, one.sequence);
      after(segment, one.segment);
    }
    for (const LoopClosure& closure : session.loop_closures) after(loop, closure.sequence);
  }
};

void renumber(Session& session, const Ends& by) {
  for (StampedPose& pose : session.trajectory) {
    pose.sequence += by.sequence;
    pose.from_sequence += by.sequence;
    pose.segment += by.segment;
  }
  for (Keyframe& keyframe : session.keyframes) {
    keyframe.sequence += by.sequence;
    keyframe.segment += by.segment;
  }
  for (CloudSlice& slice : session.slices) {
    slice.sequence += by.slice;
    slice.segment += by.segment;
    for (SliceVertex& vertex : slice.vertices) vertex.pose_sequence += static_cast<uint32_t>(by.sequence);
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
  JoinedSession joined{std::move(sessions.front()), {0}};
  Session& all = joined.session;
  for (size_t i = 1; i < sessions.size(); ++i) {
    Session& next = sessions[i];
    check_alike(all, next, i);
    const Ends ends(all);
    joined.first_sequences.push_back(ends.sequence);
    renumber(next, ends);
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
    all.integrity.truncated |= more.truncated;
    all.integrity.session_missing |= more.session_missing;
    all.integrity.final_slice_missing |= more.final_slice_missing;
  }
  return joined;
}

}  // namespace kt
