// Matches frames to poses by their stamps.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/app/placed_frames.h"

#include <algorithm>
#include <map>

namespace kt {

void for_each_placed_frame(const Trajectory& poses, std::span<const MissionFrames> missions,
                           const std::function<void(const RgbdFrame&, const Pose&, size_t)>& take,
                           const std::function<void(double)>& progress) {
  int64_t count = 0, read = 0;
  for (const MissionFrames& mission : missions) count += std::max<int64_t>(1, mission.source->frame_count());
  for (const MissionFrames& mission : missions) {
    std::map<int64_t, size_t> by_stamp;
    for (size_t i = 0; i < poses.size(); ++i) {
      const StampedPose& pose = poses[i];
      const bool is_of_mission =
          pose.sequence >= mission.first_sequence && pose.sequence < mission.end_sequence;
      if (is_of_mission && pose.status == TrackingStatus::kGood) by_stamp.emplace(pose.timestamp_us, i);
    }
    if (by_stamp.empty()) continue;
    FrameSource& source = *mission.source;
    for (SourceItem item = source.next(); item.kind != SourceItem::Kind::kEnd; item = source.next()) {
      if (item.kind != SourceItem::Kind::kFrame) continue;
      const auto found = by_stamp.find(item.frame.timestamp_us);
      if (found != by_stamp.end()) {
        const StampedPose& pose = poses[found->second];
        item.frame.sequence = pose.sequence;
        take(item.frame, pose.T_odom_camera, found->second);
      }
      progress(std::min(1.0, static_cast<double>(++read) / static_cast<double>(count)));
    }
  }
}

}  // namespace kt
