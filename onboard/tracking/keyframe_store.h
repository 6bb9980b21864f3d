// Keyframes that frames are compared with.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "onboard/tracking/feature_detector.h"
#include "onboard/tracking/frame_view.h"

namespace kt {

struct StoredKeyframe {
  int64_t sequence = 0;  ///< of its frame
  int64_t timestamp_us = 0;
  int segment = 0;
  Pose T_odom_camera = Pose::Identity();
  std::vector<Feature> features;
  KeptSurface surface;
};

class KeyframeStore {
 public:
  /// Of at most `capacity` keyframes: when it is full, some of the older half go (make_room).
  explicit KeyframeStore(int capacity) : capacity_(static_cast<size_t>(capacity)) {}

  void add(StoredKeyframe keyframe);
  int size() const { return static_cast<int>(keyframes_.size()); }
  const StoredKeyframe& at(int index) const { return keyframes_[static_cast<size_t>(index)]; }

  /// The one of `segment` not older than `since_us` whose pose is nearest by the paper's metric (distance in
  /// metres plus angle in radians, eq. 2), and how near.
  struct Nearest {
    int index = -1;
    double distance = 0;
  };
  std::optional<Nearest> nearest(int segment, const Pose& T_odom_camera, int64_t since_us) const;

 private:
  size_t capacity_;
  std::vector<StoredKeyframe> keyframes_;
};

}  // namespace kt
