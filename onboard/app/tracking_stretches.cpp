// Opens, extends and closes stretches, and keeps the longest.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/app/tracking_stretches.h"

#include <algorithm>

namespace kt {

const char* to_string(TrackingStretch::End end) {
  switch (end) {
    case TrackingStretch::End::kFound:
      return "found again";
    case TrackingStretch::End::kNewSegment:
      return "new segment";
    case TrackingStretch::End::kMissionEnd:
      return "end of mission";
  }
  return "unknown";
}

bool TrackingStretches::is_gap(int64_t interval_us) const {
  constexpr size_t kEnough = 3;  // with fewer a jump of the stamps would be the measure itself
  const size_t known = std::min(intervals_, intervals_us_.size());
  if (known < kEnough) return false;
  std::array<int64_t, 5> sorted = intervals_us_;
  std::sort(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(known));
  return interval_us > kIntervalsOfGap * sorted[known / 2];
}

void TrackingStretches::add(const StampedPose& pose) {
  const bool is_good = pose.status == TrackingStatus::kGood;
  const int64_t interval_us = last_ ? pose.timestamp_us - last_->timestamp_us : 0;
  const bool after_gap = last_ && is_gap(interval_us);

  if ((!is_good || after_gap) && !open_) {
    const StampedPose& first = after_gap ? *last_ : pose;
    open_.emplace();
    open_->stretch.first_sequence = first.sequence;
    open_->stretch.first_us = first.timestamp_us;
  }
  if (open_) {
    TrackingStretch& stretch = open_->stretch;
    if (!is_good || after_gap) {
      stretch.last_sequence = pose.sequence;
      stretch.last_us = pose.timestamp_us;
      stretch.found_by = PoseSource::kNone;
      open_->good_in_a_row = 0;
    }
    if (after_gap) stretch.gap_us += interval_us;
    if (!is_good) {
      const bool is_first = stretch.uncertain + stretch.lost == 0;
      stretch.lowest_inlier_share = is_first
                                        ? pose.quality.inlier_share
                                        : std::min(stretch.lowest_inlier_share, pose.quality.inlier_share);
      ++(pose.status == TrackingStatus::kUncertain ? stretch.uncertain : stretch.lost);
      // At least 1 us, so that the mission's first frame counts.
      const int64_t booked_us = after_gap ? 1 : std::max<int64_t>(interval_us, 1);
      open_->time_us.at(static_cast<size_t>(pose.cause)) += booked_us;
    } else {
      if (open_->good_in_a_row++ == 0) {
        stretch.found_by = pose.source;
        stretch.end = pose.source == PoseSource::kStart ? TrackingStretch::End::kNewSegment
                                                        : TrackingStretch::End::kFound;
      }
      if (open_->good_in_a_row >= kGoodFramesToEnd || pose.source == PoseSource::kStart) close();
    }
  }
  if (last_) intervals_us_[intervals_++ % intervals_us_.size()] = interval_us;
  last_ = pose;
}

void TrackingStretches::finish() {
  if (open_) close();
}

void TrackingStretches::close() {
  TrackingStretch& stretch = open_->stretch;
  if (open_->good_in_a_row == 0) stretch.end = TrackingStretch::End::kMissionEnd;
  const auto longest = std::max_element(open_->time_us.begin(), open_->time_us.end());
  stretch.is_gap = stretch.gap_us > *longest;
  if (!stretch.is_gap) stretch.cause = static_cast<TrackingCause>(longest - open_->time_us.begin());
  ++count_;
  worst_.push_back(stretch);  // in order of time, as they come
  if (worst_.size() > kKept) {
    const auto shorter = [](const TrackingStretch& a, const TrackingStretch& b) {
      return a.duration_us() < b.duration_us();
    };
    // Of equals the last one goes.
    const auto shortest = std::min_element(worst_.rbegin(), worst_.rend(), shorter);
    worst_.erase(std::next(shortest).base());
  }
  open_.reset();
}

}  // namespace kt
