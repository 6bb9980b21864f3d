// Finds a frame by its features: from the keyframe nearest to where it may be.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "onboard/tracking/feature_aligner.h"
#include "onboard/tracking/keyframe_store.h"
#include "onboard/tracking/tracker.h"

namespace kt {

class KeyframeTracker {
 public:
  KeyframeTracker(const exec::Device& device, const Calibration& calibration, const TrackingConfig& config);

  /// Where a keyframe's features say that the frame is.
  struct Found {
    int keyframe = -1;  ///< index
    FeatureAlignment alignment;
    Pose T_odom_camera = Pose::Identity();
  };

  /// The frame that the next calls are about, of a camera in `motion` as far as that is known before it is
  /// tracked. Its features are found when they are first needed.
  void look_at(const FrameMaps& maps, const FrameMotion& motion = {});

  int feature_count() { return static_cast<int>(features().size()); }

  /// From the recent keyframe of `segment` nearest to the guess; nothing where there is none near.
  std::optional<Found> find_near(int segment, const Pose& T_odom_guess);

  /// From one keyframe.
  Found find_at(int keyframe);

  /// The keyframe of `segment` nearest to a pose, however old it is.
  std::optional<int> nearest(int segment, const Pose& T_odom_camera) const;

  /// Makes a keyframe of the frame, seen from T_odom_camera by a camera in `motion`, where there is no recent
  /// one near.
  void remember(int64_t sequence, int segment, const Pose& T_odom_camera, const FrameMotion& motion);

  const StoredKeyframe& keyframe(int index) const { return store_.at(index); }

 private:
  const std::vector<Feature>& features();

  TrackingConfig config_;
  FeatureCamera camera_;
  FeatureDetector detector_;
  SurfaceMemory surfaces_;
  KeyframeStore store_;
  const FrameMaps* maps_ = nullptr;
  FrameMotion motion_;
  std::optional<std::vector<Feature>> features_;  // of maps_
};

}  // namespace kt
