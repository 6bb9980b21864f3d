// Which keyframes stay, and the nearest of them.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/tracking/keyframe_store.h"

#include <utility>

#include "shared/core/make_room.h"

namespace kt {
void KeyframeStore::add(StoredKeyframe keyframe) {
  make_room(keyframes_, capacity_);
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
