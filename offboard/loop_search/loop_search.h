// Looks for loop closures among all keyframes of a mission, without the haste of the collector.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include "onboard/loops/keyframe_index.h"
#include "onboard/loops/loop_verifier.h"
#include "shared/types/calibration.h"

namespace kt {

struct LoopSearchConfig {
  int similar = 10;             ///< places that look alike, at most, that each keyframe is compared with
  double min_similarity = 0.3;  ///< of the words, in units of that with the keyframe before
  int near = 5;                 ///< keyframes that the poses put nearest, at most, that it is compared with
  double near_movement = 0.9;   ///< metres plus radians: farther ones share too little of the view
  double drift_per_way = 0.03;  ///< and so much more for each metre and radian of the way between them
  int newest = 3;               ///< so many keyframes before it only show what odometry has just measured
  VerificationConfig verification;
};

/// Told the share done, in [0, 1].
using LoopProgress = std::function<void(double share)>;

class LoopSearch {
 public:
  /// `keyframes` ascend by sequence and carry one kind of descriptor, of one camera; a depth image that is
  /// not a quarter of its size counts as none. Throws kt::Error as vocabulary_of does.
  LoopSearch(const Calibration& calibration, std::vector<Keyframe> keyframes, const LoopSearchConfig& config,
             int threads = 0);

  const std::vector<Place>& places() const { return places_; }

  /// Compares every keyframe with the earlier ones that look alike and those that its pose puts near, as the
  /// collector does; pairs of earlier calls are left out. `T_world_camera`: poses by keyframe as far as they
  /// are known by now; `group`: by keyframe, poses of different groups have nothing to do with each other.
  /// Returns every candidate with its verdict, ascending by `to`, then `from`; numbered on from earlier
  /// calls. The result does not depend on the number of threads.
  std::vector<LoopClosure> search(std::span<const Pose> T_world_camera, std::span<const int> group,
                                  const LoopProgress& progress = {});

 private:
  using Pair = std::pair<int, int>;  // to, from
  struct Candidate {
    Pair pair;
    float similarity = 0;
  };
  std::vector<Candidate> candidates(std::span<const Pose> T_world_camera, std::span<const int> group) const;

  Calibration calibration_;
  LoopSearchConfig config_;
  int threads_;
  const Vocabulary* vocabulary_ = nullptr;  // null without keyframes
  std::vector<Place> places_;
  std::vector<BagOfWords> bags_;
  std::set<Pair> compared_;
  int64_t sequence_ = 0;
};

}  // namespace kt
