// What another sensor of the robot says about the camera's motion between two stamps.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <deque>
#include <optional>

#include "shared/types/motion_sample.h"

namespace kt {

/// Motion of the depth camera, and how well it is known.
struct RelativeMotion {
  Pose T_from_to = Pose::Identity();        ///< a part that was not measured is the identity, or zero
  Matrix6d information = Matrix6d::Zero();  ///< of a perturbation on the left; zero where not measured
  bool has_rotation = false, has_translation = false;
};

/// Keeps the last minute of a stream of motion samples. Between two samples the motion is taken as a constant
/// twist: poses are interpolated on SE(3), a velocity holds until the next. What stands in a sample says how
/// the error grows until the next one; errors of different stretches are independent, in the frame of the
/// camera as it moves.
class MotionPrior {
 public:
  /// False for a sample that is not used: its stamp is not after the last one's, it is of another kind than
  /// the first, or it measures no motion. Values must be finite.
  bool add(const MotionSample& sample);

  /// The motion between two stamps, from before to. Nothing where the samples do not reach: before the oldest
  /// kept, more than 0.2 s behind the newest (the last twist is carried on; one pose alone has none), where
  /// they leave a hole of more than 0.5 s inside the span or jump faster than 100 m/s or rad/s, or where no
  /// part is measured all along it.
  std::optional<RelativeMotion> between(int64_t from_us, int64_t to_us) const;

 private:
  struct Stretch;
  std::optional<Stretch> stretch_after(size_t i, int64_t to_us) const;

  std::deque<MotionSample> samples_;  // in the order of their stamps
};

}  // namespace kt
