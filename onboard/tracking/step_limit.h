// How far a camera can have gone; private to this folder.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstdint>
#include <numbers>

#include "onboard/tracking/tracker.h"
#include "shared/geometry/se3.h"

namespace kt {

inline constexpr double kDegree = std::numbers::pi / 180;

inline double seconds(int64_t from_us, int64_t to_us) { return static_cast<double>(to_us - from_us) * 1e-6; }

inline bool is_within(const Pose& T, double distance_m, double angle_rad) {
  return T.translation().norm() <= distance_m && rotation_angle(T) <= angle_rad;
}

/// Whether a camera moves so within `dt_s` seconds. Steps are limited as if frames came at 30 Hz; after a gap
/// it may have gone farther, up to a factor.
inline bool is_possible_step(const Pose& T_step, double dt_s, const TrackingConfig& config) {
  constexpr double kFrameRate_hz = 30, kLargestFactor = 4;
  const double factor = std::clamp(dt_s * kFrameRate_hz, 1.0, kLargestFactor);
  return is_within(T_step, factor * config.max_step_m, factor * config.max_step_deg * kDegree);
}

}  // namespace kt
