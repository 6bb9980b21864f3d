// Points of the scene that several keyframes have seen as features.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <utility>
#include <vector>

#include "shared/core/pinhole.h"
#include "shared/geometry/se3.h"
#include "shared/types/calibration.h"
#include "shared/types/keyframe.h"

namespace kt {

/// A feature of a keyframe with depth, in units of what is known of it.
struct Observation {
  int keyframe = 0;                                    ///< index
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();     ///< in the undistorted colour image, full resolution
  Eigen::Vector3d p_camera = Eigen::Vector3d::Zero();  ///< in the depth camera (m)
  double sigma_px = 1, sigma_z = 0.01;                 ///< of pixel (px) and depth (m)
};

/// Of one point, at most one by keyframe, ascending; two at least.
using FeatureTrack = std::vector<Observation>;

/// Two keyframes that see the same place.
using KeyframePair = std::pair<int, int>;

/// Tracks of the features whose descriptors agree in one of `pairs` and that the poses put within a few
/// centimetres and pixels of each other. The result does not depend on the number of threads. Throws
/// kt::Error as vocabulary_of() does.
std::vector<FeatureTrack> find_tracks(const Calibration& calibration,
                                      std::span<const Keyframe* const> keyframes,
                                      std::span<const Pose> T_world_camera,
                                      std::span<const KeyframePair> pairs, int threads);

}  // namespace kt
