// Two frames through the tests of a loop candidate, and how well its pose and the true one fit what was seen.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "onboard/loops/keyframe_maker.h"
#include "onboard/loops/loop_verifier.h"
#include "onboard/loops/vocabulary.h"

namespace kt {

/// How a relative pose fits two keyframes.
struct PoseFit {
  int64_t points = 0;        ///< depth pixels of either that lie on the surface of the other, with its normal
  double surface_rms_m = 0;  ///< of these
  double reprojection_px =
      0;  ///< root mean square over the closure's inliers, both ways, in pixels of the colour camera
  int64_t matches = 0;  ///< of all descriptors that agree, those that reproject within 4 px both ways
};

struct PairComparison {
  LoopClosure loop;
  double similarity = 0;  ///< of the bags of words, 0 to 1
  double verification_ms = 0;
  std::optional<PoseFit> fit;  ///< of loop.T_from_to, where the tests came to one
  /// Where the true relative pose is known.
  struct Truth {
    double overlap = 0;                 ///< of view_overlap.h
    double viewpoint_deg = 0;           ///< between the lines of sight to what both see: the median
    double error_m = 0, error_deg = 0;  ///< of loop.T_from_to, where there is a fit
    std::optional<PoseFit> fit;         ///< of the true pose, where there is one of the closure's
  };
  std::optional<Truth> truth;
};

/// How two views stand to each other.
struct ViewChange {
  double overlap = 0, viewpoint_deg = 0;
};
ViewChange view_change(const PinholeParams& camera, const Image<uint16_t>& from, const Image<uint16_t>& to,
                       const Pose& T_from_to);

/// A keyframe with its words.
struct KnownPlace {
  Place place;
  BagOfWords bag;
};

class PairComparer {
 public:
  /// For keyframes of this camera and kind of descriptor. Throws kt::Error where there is no vocabulary for
  /// it.
  PairComparer(const Calibration& calibration, const std::string& descriptor_type);

  const Vocabulary& vocabulary() const { return vocabulary_; }
  const PinholeParams& depth_camera() const { return depth_; }

  KnownPlace known(Keyframe keyframe) const;
  PairComparison compare(const KnownPlace& from, const KnownPlace& to,
                         const std::optional<Pose>& T_from_to_true);

 private:
  PoseFit fit(const Keyframe& from, const Keyframe& to, const LoopClosure& loop,
              std::span<const FeatureMatch> matches, const Pose& T_from_to) const;

  const Vocabulary& vocabulary_;
  PinholeParams colour_, depth_;
  Pose T_colour_depth_;
  double readout_s_;
  LoopVerifier verifier_;
};

}  // namespace kt
