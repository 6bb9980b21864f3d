// True revisits from true poses and depth images; closures and candidates held against them.
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/eval/loop_evaluation.h"

#include <algorithm>
#include <map>
#include <numbers>
#include <string>
#include <utility>

#include "shared/core/check.h"
#include "shared/core/parallel.h"
#include "tools/eval/groundtruth.h"
#include "tools/eval/view_overlap.h"

namespace kt {
namespace {

constexpr double kRevisitOverlap = 0.5, kAwayOverlap = 0.2;
constexpr double kRevisitDistance_m = 1, kRevisitAngle_deg = 40;
constexpr double kCorrect_m = 0.05, kCorrect_deg = 3;
constexpr int64_t kMaxGap = 1;  // keyframes without a revisit that an event survives

double degrees(double radians) { return radians * 180 / std::numbers::pi; }

/// A keyframe that takes part.
struct Place {
  int64_t sequence = 0;
  Pose T_truth_camera;
  const Image<uint16_t>* depth = nullptr;
};

/// In order of their frames.
std::vector<Place> places_of(const Session& session, const Trajectory& groundtruth,
                             const PinholeParams& camera) {
  std::vector<int64_t> stamps_us;
  for (const Keyframe& keyframe : session.keyframes) stamps_us.push_back(keyframe.timestamp_us);
  const std::vector<std::optional<Pose>> truth = poses_at(groundtruth, stamps_us);
  if (!truth.empty() && std::none_of(truth.begin(), truth.end(), [](const auto& pose) { return !!pose; })) {
    throw Error("no keyframe of the log has a ground truth near its stamp; do the two share a clock?");
  }
  std::map<int64_t, Place> places;
  for (size_t k = 0; k < truth.size(); ++k) {
    const Keyframe& keyframe = session.keyframes[k];
    const Image<uint16_t>& depth = keyframe.depth;
    if (!truth[k] || depth.empty()) continue;
    if (depth.width() != camera.width || depth.height() != camera.height) {
      throw Error("the depth image of keyframe " + std::to_string(keyframe.sequence) + " is " +
                  std::to_string(depth.width()) + " x " + std::to_string(depth.height()) +
                  ", a quarter of the session's depth camera is " + std::to_string(camera.width) + " x " +
                  std::to_string(camera.height));
    }
    places.try_emplace(keyframe.sequence, Place{keyframe.sequence, *truth[k], &depth});
  }
  std::vector<Place> result;
  for (auto& [sequence, place] : places) result.push_back(place);
  return result;
}

/// For each place j, ascending, the places i of its true revisits.
std::vector<std::vector<size_t>> revisits_of(const std::vector<Place>& places, const PinholeParams& camera) {
  std::vector<std::vector<size_t>> revisits(places.size());
  for_each_in_parallel(static_cast<int64_t>(places.size()), 0, [&](int64_t index) {
    const size_t j = static_cast<size_t>(index);
    const auto T_j = [&](size_t i) -> Pose {
      return places[i].T_truth_camera.inverse() * places[j].T_truth_camera;
    };
    const auto shares = [&](size_t i, double share) {
      return overlaps(camera, *places[i].depth, *places[j].depth, T_j(i), share);
    };
    // The last place away from j: what lies before it, and only that, has one in between.
    size_t away = j;
    do {
      if (away == 0) return;
      --away;
    } while (shares(away, kAwayOverlap));
    for (size_t i = 0; i < away; ++i) {
      const Pose T = T_j(i);
      if (T.translation().norm() <= kRevisitDistance_m && degrees(rotation_angle(T)) <= kRevisitAngle_deg &&
          shares(i, kRevisitOverlap))
        revisits[j].push_back(i);
    }
  });
  return revisits;
}

/// What the log says of each place, as the later end of a pair.
struct PlaceFate {
  bool is_proposed = false, is_recalled = false;
};

std::vector<LoopEvaluation::Event> events_of(const std::vector<Place>& places,
                                             const std::vector<std::vector<size_t>>& revisits,
                                             const std::vector<PlaceFate>& fates) {
  std::vector<LoopEvaluation::Event> events;
  int64_t last = -kMaxGap - 2;
  for (size_t j = 0; j < places.size(); ++j) {
    if (revisits[j].empty()) continue;
    const auto index = static_cast<int64_t>(j);
    const bool continues = index - last - 1 <= kMaxGap;
    if (!continues) events.push_back({places[j].sequence, 0, 0, false});
    LoopEvaluation::Event& event = events.back();
    event.last = places[j].sequence;
    ++event.keyframes;
    for (size_t k = continues ? static_cast<size_t>(last) + 1 : j; k <= j; ++k)
      event.is_recalled |= fates[k].is_recalled;
    last = index;
  }
  return events;
}

}  // namespace

LoopEvaluation evaluate_loops(const Session& session, const Trajectory& groundtruth) {
  if (session.integrity.session_missing)
    throw Error("the log has no session event, so the camera of its keyframes is not known");
  const PinholeParams camera = keyframe_camera(session.header.calibration);
  const std::vector<Place> places = places_of(session, groundtruth, camera);
  const std::vector<std::vector<size_t>> revisits = revisits_of(places, camera);
  std::map<int64_t, size_t> index_of;
  for (size_t k = 0; k < places.size(); ++k) index_of[places[k].sequence] = k;

  LoopEvaluation result;
  result.keyframes = static_cast<int64_t>(session.keyframes.size());
  result.keyframes_left_out = result.keyframes - static_cast<int64_t>(places.size());
  std::vector<PlaceFate> fates(places.size());
  for (const LoopClosure& loop : session.loop_closures) {
    const auto verdict = static_cast<size_t>(loop.verdict);
    ++result.by_verdict[verdict];
    const auto from = index_of.find(loop.from), to = index_of.find(loop.to);
    if (to == index_of.end()) continue;
    PlaceFate& fate = fates[to->second];
    fate.is_proposed = true;
    if (from == index_of.end()) continue;
    const std::vector<size_t>& true_ones = revisits[to->second];
    if (std::binary_search(true_ones.begin(), true_ones.end(), from->second))
      ++result.revisits_by_verdict[verdict];
    if (!loop.accepted()) continue;
    const Pose T_from_to_truth =
        places[from->second].T_truth_camera.inverse() * places[to->second].T_truth_camera;
    const Pose E = T_from_to_truth.inverse() * loop.T_from_to;
    LoopEvaluation::JudgedClosure judged{loop.from, loop.to, E.translation().norm(),
                                         degrees(rotation_angle(E)), false};
    judged.is_correct = judged.translation_m < kCorrect_m && judged.rotation_deg < kCorrect_deg;
    fate.is_recalled |= judged.is_correct;
    result.judged.push_back(judged);
  }
  for (size_t j = 0; j < places.size(); ++j) {
    if (revisits[j].empty()) continue;
    ++result.revisit_keyframes;
    result.recalled_keyframes += fates[j].is_recalled;
    result.unproposed_keyframes += !fates[j].is_proposed;
  }
  result.events = events_of(places, revisits, fates);
  return result;
}

int64_t LoopEvaluation::candidates() const {
  int64_t sum = 0;
  for (const int64_t count : by_verdict) sum += count;
  return sum;
}

int64_t LoopEvaluation::correct() const {
  return std::count_if(judged.begin(), judged.end(), [](const JudgedClosure& c) { return c.is_correct; });
}

int64_t LoopEvaluation::recalled_events() const {
  return std::count_if(events.begin(), events.end(), [](const Event& event) { return event.is_recalled; });
}

std::optional<double> LoopEvaluation::precision() const {
  if (judged.empty()) return std::nullopt;
  return static_cast<double>(correct()) / static_cast<double>(judged.size());
}

std::optional<Statistics> LoopEvaluation::translation_m() const {
  std::vector<double> errors;
  for (const JudgedClosure& closure : judged) errors.push_back(closure.translation_m);
  return errors.empty() ? std::nullopt : std::optional(summarise(errors));
}

std::optional<Statistics> LoopEvaluation::rotation_deg() const {
  std::vector<double> errors;
  for (const JudgedClosure& closure : judged) errors.push_back(closure.rotation_deg);
  return errors.empty() ? std::nullopt : std::optional(summarise(errors));
}

}  // namespace kt
