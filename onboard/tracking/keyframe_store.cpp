// Which keyframes stay, and the nearest of them.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/tracking/keyframe_store.h"

#include <utility>

namespace kt {
void KeyframeStore::add(StoredKeyframe keyframe) {
  if (keyframes_.size() >= capacity_) {
    size_t index = 0;
    const size_t older = keyframes_.size() / 2;
    std::erase_if(keyframes_, [&](const StoredKeyframe&) { return index < older && index++ % 2 == 1; });
    if (keyframes_.size() >= capacity_) keyframes_.erase(keyframes_.begin());  // a half too small to thin out
  }
  keyframes_.push_back(std::move(keyframe));
}

std::optional<KeyframeStore::Nearest> KeyframeStore::nearest(int segment, const Pose& T_odom_camera,
                                                             int64_t since_us) const {
  std::optional<Nearest> best;
  for (int i = 0; i < size(); ++i) {
    if (at(i).segment != segment || at(i).timestamp_us < since_us) continue;
    const double distance = movement(at(i).T_odom_camera.inverse() * T_odom_camera);
    if (!best || distance < best->distance) best = {i, distance};
  }
  return best;
}

}  // namespace kt
