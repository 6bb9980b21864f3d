// Keyframes that a lost camera is looked for among.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "onboard/tracking/feature_detector.h"
#include "onboard/tracking/frame_view.h"

namespace kt {

/// The look of a place in 512 bits, to be compared by the bits that differ.
using PlaceCode = std::array<uint64_t, 8>;

struct StoredKeyframe {
  int64_t sequence = 0;  ///< of its frame
  int64_t timestamp_us = 0;
  int segment = 0;
  Pose T_odom_camera = Pose::Identity();
  std::vector<Feature> features;
  KeptSurface surface;
  PlaceCode code{};
};

class KeyframeStore {
 public:
  /// Of at most `capacity` keyframes: when it is full, every second of the older half goes.
  KeyframeStore(const exec::Device& device, int capacity);

  PlaceCode code_of(const FrameMaps& maps);

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

  /// Up to `count` that look most like `code`, best first, and after those `others` more in turn, so that
  /// repeated calls come to every keyframe whatever it looks like.
  std::vector<int> candidates(const PlaceCode& code, int count, int others);

 private:
  exec::Device device_;
  size_t capacity_;
  exec::Buffer<PlaceBit::Pair> pairs_;
  exec::Buffer<uint8_t> bits_;
  std::vector<StoredKeyframe> keyframes_;
  size_t turn_ = 0;
};

}  // namespace kt
