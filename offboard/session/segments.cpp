// Sorts poses and slices into segments.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/session/segments.h"

#include <algorithm>
#include <map>
#include <utility>

#include "shared/core/check.h"

namespace kt {

int64_t Segment::good_frames() const {
  return std::count_if(trajectory.begin(), trajectory.end(),
                       [](const StampedPose& pose) { return pose.status == TrackingStatus::kGood; });
}

std::vector<Segment> take_segments(Session& session) {
  std::map<int, Segment> by_number;
  for (StampedPose& pose : session.trajectory) by_number[pose.segment].trajectory.push_back(std::move(pose));
  for (const SliceInfo& slice : session.slices) by_number[slice.segment].slices.push_back(slice);
  session.trajectory.clear();
  session.slices.clear();
  std::vector<Segment> segments;
  for (auto& [number, segment] : by_number) {
    segment.number = number;
    segments.push_back(std::move(segment));
  }
  return segments;
}

Importance importance_of(const Segment& segment) {
  return {segment.good_frames(), !segment.trajectory.empty()};
}

size_t main_index(std::span<const Importance> importances) {
  KT_CHECK(!importances.empty());
  return static_cast<size_t>(std::max_element(importances.begin(), importances.end()) - importances.begin());
}

size_t main_segment(std::span<const Segment> segments) {
  std::vector<Importance> importances;
  for (const Segment& segment : segments) importances.push_back(importance_of(segment));
  return main_index(importances);
}

}  // namespace kt
