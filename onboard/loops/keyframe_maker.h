// Makes keyframes: keypoints, their points, depth and a thumbnail.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <vector>

#include "onboard/loops/feature_extractor.h"
#include "onboard/preprocess/frame_motion.h"
#include "onboard/preprocess/preprocessor.h"
#include "shared/types/keyframe.h"
#include "shared/types/stamped_pose.h"

namespace kt {

/// What places are recognised by.
enum class PlaceFeature { kSurf, kCorners };

/// Of a frame, what a keyframe is made of, in host memory.
struct KeyframeImages {
  StampedPose pose;
  FrameMotion motion;
  Image<float> intensity;         ///< of the undistorted colour camera at half its resolution
  std::vector<float> depth;       ///< of the depth camera at half its resolution, bordered (m)
  Image<uint16_t> quarter_depth;  ///< at a quarter of it (mm)
  Image<Rgb8> thumbnail;
};

class KeyframeMaker {
 public:
  /// Works on one CPU thread.
  KeyframeMaker(const Calibration& calibration, PlaceFeature feature);

  const DescriptorKind& kind() const { return extractor_->kind(); }

  /// Copies what make() needs.
  static KeyframeImages images_of(const FrameMaps& maps, const Image<Rgb8>& colour, const StampedPose& pose,
                                  const FrameMotion& motion = {});

  Keyframe make(const KeyframeImages& images);

 private:
  Pose T_colour_depth_;
  PinholeParams colour_, depth_;  // at half the resolution
  int magnification_;             // of the image that features are looked for in
  std::unique_ptr<FeatureExtractor> extractor_;
};

}  // namespace kt
