// A camera pose of the trajectory, how it was found, and how far it can be trusted.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "shared/geometry/se3.h"

namespace kt {

enum class TrackingStatus : uint8_t {
  kGood = 0,       ///< pose measured, frame fused
  kUncertain = 1,  ///< pose estimated, frame not fused
  kLost = 2,       ///< pose repeated from the last good frame, frame not fused
};

/// "good", "uncertain" or "lost".
const char* to_string(TrackingStatus status);

/// What gave a pose.
enum class PoseSource : uint8_t {
  kNone = 0,         ///< nothing: it is repeated from the last good frame
  kStart = 1,        ///< it begins a segment
  kModel = 2,        ///< alignment with the model from the predicted motion
  kFeatures = 3,     ///< feature visual odometry
  kPairwise = 4,     ///< alignment with the last good frame
  kRelocalised = 5,  ///< alignment with a stored keyframe
  kPrior = 6,        ///< what another sensor said about the motion
};
inline constexpr int kPoseSources = 7;

/// "none", "start", "model", "features", "pairwise", "relocalised" or "prior".
const char* to_string(PoseSource source);

/// Why a frame is not good.
enum class TrackingCause : uint8_t {
  kNone = 0,           ///< it is
  kNoDepth = 1,        ///< too little measured: a covered lens, glass, the open sky
  kLowOverlap = 2,     ///< hardly any known surface in view
  kFewInliers = 3,     ///< the surface in view does not fit the known one
  kLargeStep = 4,      ///< the motion found is not to be believed
  kUnconstrained = 5,  ///< neither geometry nor texture tells a direction, for too long
  kUnconfirmed = 6,    ///< fair, but after a gap, a loss or a relocalisation that is not enough
  kNoFrames = 7,       ///< there is no frame: the camera is gone (of a status, never of a pose)
};
inline constexpr int kTrackingCauses = 8;

/// "none", "no depth", "low overlap", "few inliers", "large step", "unconstrained", "unconfirmed" or "no
/// frames".
const char* to_string(TrackingCause cause);

/// How well a frame fits.
struct TrackingQuality {
  double inlier_share = 0;  ///< of the pixels that fall on model surface
  double overlap = 0;       ///< share of the pixels measured inside the volume that do so
  double residual_m = 0;    ///< weighted root mean square of the point-to-plane residuals
  double conditioning = 0;  ///< smallest eigenvalue of the normalised Hessian: 0 where a direction is free
  int free_directions = 0;  ///< of the six, how many kept the guess
};

/// A camera pose in the odom frame of a segment.
struct SegmentPose {
  int segment = 0;
  Pose T_odom_camera = Pose::Identity();
};

/// A pose graph node with its odometry edge.
struct StampedPose {
  int64_t sequence = 0;  ///< of the frame
  int64_t timestamp_us = 0;
  Pose T_odom_camera = Pose::Identity();
  /// Sequence of the frame that this one was measured against, at which its edge starts: the last good one
  /// before it, or a keyframe where its features gave the pose; of the first pose of a segment its own.
  int64_t from_sequence = 0;
  /// Information of that edge: inverse covariance of the left perturbation xi of T_from_current, [rotation
  /// (rad); translation (m)]. Zero for the first pose of a segment.
  Matrix6d information = Matrix6d::Zero();
  TrackingStatus status = TrackingStatus::kGood;
  /// Counts the stretches of the mission between which the camera was lost for good, from 0. Each has an
  /// odom frame of its own; nothing is known of how they stand to each other.
  int segment = 0;
  PoseSource source = PoseSource::kNone;
  TrackingCause cause = TrackingCause::kNone;
  TrackingQuality quality{};
};

using Trajectory = std::vector<StampedPose>;

/// Twist of the camera in its own frame from one pose to the next, [rad/s; m/s]; nothing where they do not
/// follow each other: another segment, a lost one, too long a gap.
std::optional<Vector6d> velocity_between(const StampedPose& from, const StampedPose& to);

/// Of the camera in its own frame at each pose, [rad/s; m/s]: the mean of the motions before and after it, as
/// far as good or uncertain poses of its segment follow each other; zero where nothing is known.
std::vector<Vector6d> velocities(const Trajectory& trajectory);

/// Where the camera was at the stamps, for poses that were measured `stamp_delay_s` before them
/// (Calibration::stamp_delay_s), by the velocity to the next pose or, where none follows, from the last one.
/// Nothing else changes.
Trajectory at_stamps(const Trajectory& measured, double stamp_delay_s);

}  // namespace kt
