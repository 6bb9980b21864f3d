// A pinhole camera with Brown-Conrady lens distortion.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <array>
#include <string>

#include "shared/core/pinhole.h"

namespace kt {

/// Intrinsics in pixels; `distortion` is {k1, k2, p1, p2, k3} as OpenCV and the TUM benchmark define them.
struct Camera {
  int width = 640, height = 480;
  double fx = 525, fy = 525, cx = 319.5, cy = 239.5;
  std::array<double, 5> distortion{};

  bool is_distorted() const;

  /// Where a point of the camera frame (m, z > 0) is seen in the distorted image, in pixels.
  Eigen::Vector2d project(const Eigen::Vector3d& p_camera) const;

  /// The undistorted camera of the same intrinsics.
  PinholeParams pinhole() const;

  /// The camera as kernels take it.
  DistortedPinholeParams distorted_pinhole() const;

  /// Empty where the intrinsics make sense, else what is wrong with them ("fx is -480, must lie in [57.6,
  /// 7680]"): each number for itself, and the distortion over the whole image.
  std::string problem() const;
  /// The first part of it: numbers out of range.
  std::string range_problem() const;

  friend bool operator==(const Camera&, const Camera&) = default;

 private:
  /// Whether distortion turns the image over around (x, y) = (X / Z, Y / Z): it must keep directions from the
  /// centre (radial factor above 0) and orientation (its Jacobian's determinant above 0).
  bool folds_at(double x, double y) const;
};

}  // namespace kt
