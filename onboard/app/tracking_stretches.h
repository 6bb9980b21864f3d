// Where in a mission the tracking was in trouble: the worst stretches, for the end report.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "shared/types/stamped_pose.h"

namespace kt {

/// A run of frames that are not good, with what few good ones lie between them, or a time without frames.
struct TrackingStretch {
  enum class End : uint8_t {
    kFound,       ///< the camera was found again, by `found_by`
    kNewSegment,  ///< a segment began, the first one or another
    kMissionEnd,  ///< it was not
  };

  /// The first and the last frame that is not good; where a gap begins or ends the stretch, the frame before
  /// or behind it.
  int64_t first_sequence = 0, last_sequence = 0;
  int64_t first_us = 0, last_us = 0;
  int64_t uncertain = 0, lost = 0;  ///< frames
  int64_t gap_us = 0;               ///< time without frames, in all
  /// What lasted longest; kNone where frames were not good and said no cause, or where it was a gap.
  TrackingCause cause = TrackingCause::kNone;
  bool is_gap = false;             ///< the gap lasted longer than any cause
  double lowest_inlier_share = 0;  ///< of its frames that are not good; 0 where there are none
  End end = End::kMissionEnd;
  PoseSource found_by = PoseSource::kNone;  ///< of the first good pose behind it; kNone at the mission's end

  int64_t duration_us() const { return last_us - first_us; }
};

/// "found again", "new segment" or "end of mission".
const char* to_string(TrackingStretch::End end);

/// Watches the poses of a mission. Its memory does not grow with the mission, and nothing depends on the
/// clock.
class TrackingStretches {
 public:
  /// So many are kept, those that last longest; of equals the earlier ones.
  static constexpr size_t kKept = 10;
  /// So many good frames in a row end a stretch; fewer are an interruption of it.
  static constexpr int kGoodFramesToEnd = 10;
  /// A time without frames is a gap from so many usual frame intervals on: medians of the last five.
  static constexpr int kIntervalsOfGap = 5;

  /// Takes the poses in order of their stamps.
  void add(const StampedPose& pose);

  /// Ends the stretch that is under way. Call once, after the last pose.
  void finish();

  /// In order of time, after finish().
  const std::vector<TrackingStretch>& worst() const { return worst_; }
  /// Of all stretches, those that are not kept too.
  int64_t count() const { return count_; }

 private:
  // A stretch under way.
  struct Open {
    TrackingStretch stretch;
    std::array<int64_t, kTrackingCauses> time_us{};  // by cause
    int good_in_a_row = 0;
  };

  bool is_gap(int64_t interval_us) const;
  void close();

  std::optional<StampedPose> last_;
  std::array<int64_t, 5> intervals_us_{};  // a ring of the last ones
  size_t intervals_ = 0;                   // so far
  std::optional<Open> open_;
  std::vector<TrackingStretch> worst_;
  int64_t count_ = 0;
};

}  // namespace kt
