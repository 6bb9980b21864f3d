// Relative pose of two frames from their features: visual odometry in the manner of FOVIS (Huang et al.
// 2011), by published parts.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include "onboard/tracking/feature_detector.h"
#include "shared/types/calibration.h"

namespace kt {

enum class FeatureStatus {
  kOk,
  kTooFewFeatures,     ///< one of the frames shows hardly any corner with a depth
  kTooFewMatches,      ///< their descriptors do not agree
  kTooFewInliers,      ///< no rigid motion explains enough of the matches
  kUnconstrained,      ///< the inliers leave a direction of motion open
  kReprojectionError,  ///< the best motion explains its own inliers badly
};

/// "ok", "too few features", "too few matches", "too few inliers", "unconstrained" or "reprojection error".
const char* to_string(FeatureStatus status);

struct FeatureMatch {
  int a = 0, b = 0;  // indices into the features of either frame
};

/// Pairs of features whose descriptors are each other's nearest, and clearly so.
std::vector<FeatureMatch> match_features(std::span<const Feature> a, std::span<const Feature> b);

struct FeatureAlignment {
  FeatureStatus status = FeatureStatus::kTooFewFeatures;
  Pose T_a_b = Pose::Identity();            ///< of kOk, between the depth cameras
  Matrix6d information = Matrix6d::Zero();  ///< of the left perturbation of T_a_b
  int matches = 0, inliers = 0;
  std::vector<FeatureMatch> inlier_matches;  ///< of kOk
  double rms_px = 0;  ///< of the inliers' reprojections, in pixels of the level each was found at
};

/// How a match looks under a motion.
struct FeatureCamera {
  PinholeParams camera;  ///< colour, of intensity level 0
  Pose T_colour_depth = Pose::Identity();
};

/// Residuals of one match in standard deviations: b's point seen in a, a's point seen in b (2 pixels each),
/// and the difference of depth in a; with their derivatives by the left perturbation of T_a_b.
struct FeatureResidual {
  Eigen::Matrix<double, 5, 1> r;
  Eigen::Matrix<double, 5, 6> J;
  bool is_visible = false;  ///< false where a point lies behind a camera: the rest means nothing
};
FeatureResidual feature_residual(const Feature& a, const Feature& b, const Pose& T_a_b,
                                 const FeatureCamera& camera);

/// The rigid motion T_a_b that brings the points of b nearest to those of a, each pair by its certainty
/// (Umeyama 1991 without scale). Needs three matches that lie on no line.
Pose absolute_orientation(std::span<const Feature> a, std::span<const Feature> b,
                          std::span<const FeatureMatch> matches, const FeatureCamera& camera);

/// Whether b's point, moved into a, falls on a's pixel and lies at its depth, but for noise.
bool is_explained(const Feature& a, const Feature& b, const Pose& T_a_b, const FeatureCamera& camera);

/// Sums of the residuals of matches, robustly weighted.
struct FeatureEquations {
  Matrix6d A = Matrix6d::Zero();
  Vector6d b = Vector6d::Zero();
  double squares = 0, reprojection_squares = 0;
  /// Of so many matches, as a factor of A: they tell less than their number, and least where they fit badly.
  double trust(size_t matches) const;
};
FeatureEquations feature_equations(std::span<const Feature> a, std::span<const Feature> b,
                                   std::span<const FeatureMatch> matches, const Pose& T_a_b,
                                   const FeatureCamera& camera);

/// Refines a motion that explains `inliers`, some of `matches`, by damped Gauss-Newton on reprojections both
/// ways and depth; which matches are inliers is decided anew on the way.
FeatureAlignment refine_alignment(std::span<const Feature> a, std::span<const Feature> b,
                                  std::span<const FeatureMatch> matches, const Pose& T_a_b_guess,
                                  std::vector<FeatureMatch> inliers, const FeatureCamera& camera,
                                  int min_inliers);

/// Matches `a` with `b`, keeps a largest set of matches whose distances between points agree (a clique, found
/// greedily; the tolerance grows with the noise of depth, z^2), and refines the motion on reprojections both
/// ways and depth. Deterministic: nothing is drawn.
FeatureAlignment align_features(std::span<const Feature> a, std::span<const Feature> b,
                                const FeatureCamera& camera, int min_inliers);

}  // namespace kt
