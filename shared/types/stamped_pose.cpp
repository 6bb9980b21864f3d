// Names of the tracking states.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/types/stamped_pose.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "shared/types/names.h"

namespace kt {

const char* to_string(TrackingStatus status) {
  return name_of(std::array{"good", "uncertain", "lost"}, static_cast<size_t>(status));
}

const char* to_string(PoseSource source) {
  constexpr std::array<const char*, kPoseSources> kNames = {"none",     "start",       "model", "features",
                                                            "pairwise", "relocalised", "prior"};
  return name_of(kNames, static_cast<size_t>(source));
}

const char* to_string(TrackingCause cause) {
  constexpr std::array<const char*, kTrackingCauses> kNames = {"none",        "no depth",   "low overlap",
                                                               "few inliers", "large step", "unconstrained",
                                                               "unconfirmed", "no frames"};
  return name_of(kNames, static_cast<size_t>(cause));
}

std::optional<Vector6d> velocity_between(const StampedPose& from, const StampedPose& to) {
  constexpr double kLongestStep_s = 0.2;  // beyond, a camera that is held by hand may have gone anywhere
  const double dt_s = static_cast<double>(to.timestamp_us - from.timestamp_us) * 1e-6;
  if (from.segment != to.segment || from.status == TrackingStatus::kLost ||
      to.status == TrackingStatus::kLost || dt_s <= 0 || dt_s > kLongestStep_s)
    return std::nullopt;
  return log_se3(from.T_odom_camera.inverse() * to.T_odom_camera) / dt_s;
}

std::vector<Vector6d> velocities(const Trajectory& trajectory) {
  std::vector<Vector6d> result(trajectory.size(), Vector6d::Zero());
  std::vector<int> motions(trajectory.size());
  for (size_t i = 0; i + 1 < trajectory.size(); ++i) {
    const auto velocity = velocity_between(trajectory[i], trajectory[i + 1]);
    if (!velocity) continue;
    for (const size_t end : {i, i + 1}) {
      result[end] += *velocity;
      ++motions[end];
    }
  }
  for (size_t i = 0; i < result.size(); ++i) result[i] /= std::max(1, motions[i]);
  return result;
}

Trajectory at_stamps(const Trajectory& measured, double stamp_delay_s) {
  if (stamp_delay_s == 0) return measured;
  Trajectory result = measured;
  for (size_t i = 0; i < measured.size(); ++i) {
    std::optional<Vector6d> before, after;
    if (i > 0) before = velocity_between(measured[i - 1], measured[i]);
    if (i + 1 < measured.size()) after = velocity_between(measured[i], measured[i + 1]);
    if (stamp_delay_s < 0) std::swap(before, after);
    if (const auto& velocity = after ? after : before)
      result[i].T_odom_camera = measured[i].T_odom_camera * exp_se3(*velocity * stamp_delay_s);
  }
  return result;
}

}  // namespace kt
