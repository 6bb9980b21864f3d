// Place recognition against the truth: which revisits of a mission it found, and whether what it accepted
// holds.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "shared/types/session.h"
#include "tools/eval/statistics.h"

namespace kt {

/// Definitions. All poses are true ones: ground truth at the stamp of the keyframe, interpolated (poses_at).
/// The overlap of two keyframes is that of view_overlap.h.
/// - A pair i < j is a *true revisit* where the overlap is at least 50 %, the cameras stand at most 1 m and
/// 40
///   degrees apart, and the camera has been away in between: a keyframe between i and j overlaps j by less
///   than 20 %.
/// - A *revisit event* is a run of keyframes j that each have a true revisit; one keyframe without, between
/// two
///   that have one, does not end it.
/// - An accepted closure is *correct* where T_from_to is less than 5 cm and 3 degrees off. The truth counts
/// as
///   exact, which that of a motion capture is not: therefore the errors themselves are told too.
/// - A keyframe or an event is *recalled* where a correct closure ends at it. Its pair need not be a true
///   revisit: one that overlaps by 45 % serves as well.
/// Keyframes without depth or truth take no part; closures that touch one are not judged.
struct LoopEvaluation {
  struct Event {
    int64_t first = 0, last = 0;  ///< sequences of the frames
    int64_t keyframes = 0;        ///< that have a true revisit
    bool is_recalled = false;
  };
  struct JudgedClosure {
    int64_t from = 0, to = 0;  ///< sequences of the frames
    double translation_m = 0,
           rotation_deg = 0;  ///< of T_from_to true^-1 * T_from_to: how far off camera `to` is
    bool is_correct = false;
  };

  int64_t keyframes = 0;           ///< of the log
  int64_t keyframes_left_out = 0;  ///< of these, without truth or depth

  std::vector<Event> events;         ///< in order of time
  int64_t revisit_keyframes = 0;     ///< with a true revisit
  int64_t recalled_keyframes = 0;    ///< of these
  int64_t unproposed_keyframes = 0;  ///< of these, without any candidate that ends at them
  std::vector<JudgedClosure>
      judged;  ///< accepted closures between keyframes that take part, in order of the log

  /// Candidates of the log by LoopVerdict; and those among them whose pair is a true revisit.
  std::array<int64_t, kLoopVerdicts> by_verdict{}, revisits_by_verdict{};

  int64_t candidates() const;
  int64_t accepted() const { return by_verdict[static_cast<size_t>(LoopVerdict::kAccepted)]; }
  int64_t correct() const;
  int64_t recalled_events() const;
  /// Correct of those judged; nothing where none was judged.
  std::optional<double> precision() const;
  /// Of the judged closures, nothing where there are none.
  std::optional<Statistics> translation_m() const, rotation_deg() const;
};

/// Throws kt::Error where the log has lost its session event (and with it the camera), where a depth image
/// has another size than its calibration says, and where it has keyframes but no ground truth is near any of
/// them.
LoopEvaluation evaluate_loops(const Session& session, const Trajectory& groundtruth);

}  // namespace kt
