// Match, clique, absolute orientation, Gauss-Newton.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/tracking/feature_aligner.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/SVD>
#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "onboard/tracking/nearest_two.h"

namespace kt {
namespace {

// Of 256 bits; and how much nearer the best must be than the second best.
constexpr int kMaxDistance = 64;
constexpr double kMaxRatio = 0.85;

constexpr double kPixelSigma = 0.7;  // of a corner, in pixels of its level
constexpr double kGateSigmas = 3;
constexpr int kSeeds = 4, kRounds = 2, kIterations = 6;
constexpr double kMaxRms = 2.5;  // in standard deviations

// Inliers lie on few surfaces and share the errors of both frames: they tell less than their number.
constexpr double kCorrelation = 4;

// A motion known less well than this is not known.
constexpr double kMaxRotationSigma = 0.05, kMaxTranslationSigma = 0.1;  // rad, m

double depth_sigma(const Feature& feature) {
  return static_cast<double>(depth_sigma_m(static_cast<float>(feature.p_camera.z())));
}
double pixel_sigma(const Feature& feature) { return kPixelSigma * (1 << feature.level); }

// Variance (m^2) of a feature's point, in whichever direction is worst.
double point_variance(const Feature& feature, const FeatureCamera& camera) {
  const double across = pixel_sigma(feature) * feature.p_camera.z() / static_cast<double>(camera.camera.fx);
  return depth_sigma(feature) * depth_sigma(feature) + across * across;
}

/// Which pairs of matches keep their distance, one row of bits per match.
class ConsistencyGraph {
 public:
  using Words = std::vector<uint64_t>;

  ConsistencyGraph(std::span<const Feature> a, std::span<const Feature> b,
                   std::span<const FeatureMatch> matches, const FeatureCamera& camera)
      : rows_(matches.size(), Words((matches.size() + 63) / 64)) {
    std::vector<double> variances;
    for (const FeatureMatch& match : matches) {
      variances.push_back(point_variance(a[static_cast<size_t>(match.a)], camera) +
                          point_variance(b[static_cast<size_t>(match.b)], camera));
    }
    for (size_t i = 0; i < matches.size(); ++i) {
      for (size_t j = 0; j < i; ++j) {
        const auto distance = [i, j, &matches](std::span<const Feature> features, int FeatureMatch::*side) {
          return (features[static_cast<size_t>(matches[i].*side)].p_camera -
                  features[static_cast<size_t>(matches[j].*side)].p_camera)
              .norm();
        };
        const double change = distance(a, &FeatureMatch::a) - distance(b, &FeatureMatch::b);
        if (change * change > kGateSigmas * kGateSigmas * (variances[i] + variances[j])) continue;
        set(rows_[i], j);
        set(rows_[j], i);
      }
    }
  }

  /// A clique with match `seed`: the candidate that leaves most candidates is added, until none is left.
  std::vector<int> clique_with(int seed) const {
    std::vector<int> clique = {seed};
    Words candidates = rows_[static_cast<size_t>(seed)];
    while (true) {
      int best = -1, best_left = -1;
      for (int i = 0; i < static_cast<int>(rows_.size()); ++i) {
        if (!has(candidates, static_cast<size_t>(i))) continue;
        int left = 0;
        for (size_t w = 0; w < candidates.size(); ++w)
          left += std::popcount(candidates[w] & rows_[static_cast<size_t>(i)][w]);
        if (left > best_left) best_left = left, best = i;
      }
      if (best < 0) return clique;
      clique.push_back(best);
      for (size_t w = 0; w < candidates.size(); ++w) candidates[w] &= rows_[static_cast<size_t>(best)][w];
    }
  }

  /// The largest of the cliques around the best connected matches.
  std::vector<int> largest_clique() const {
    std::vector<std::pair<int, int>> by_degree;  // negative degree, match
    for (int i = 0; i < static_cast<int>(rows_.size()); ++i) {
      int degree = 0;
      for (const uint64_t word : rows_[static_cast<size_t>(i)]) degree += std::popcount(word);
      by_degree.emplace_back(-degree, i);
    }
    std::sort(by_degree.begin(), by_degree.end());
    std::vector<int> largest;
    int seeds = 0;
    for (const auto& [degree, match] : by_degree) {
      if (std::find(largest.begin(), largest.end(), match) != largest.end()) continue;
      std::vector<int> clique = clique_with(match);
      if (clique.size() > largest.size()) largest = std::move(clique);
      if (++seeds == kSeeds) break;
    }
    std::sort(largest.begin(), largest.end());
    return largest;
  }

 private:
  static void set(Words& words, size_t bit) { words[bit / 64] |= uint64_t{1} << (bit % 64); }
  static bool has(const Words& words, size_t bit) { return words[bit / 64] >> (bit % 64) & 1; }
  std::vector<Words> rows_;
};

}  // namespace

Pose absolute_orientation(std::span<const Feature> a, std::span<const Feature> b,
                          std::span<const FeatureMatch> matches, const FeatureCamera& camera) {
  Eigen::Vector3d mean_a = Eigen::Vector3d::Zero(), mean_b = Eigen::Vector3d::Zero();
  double weights = 0;
  const auto for_each_pair = [&](const auto& body) {
    for (const FeatureMatch& match : matches) {
      const Feature &fa = a[static_cast<size_t>(match.a)], &fb = b[static_cast<size_t>(match.b)];
      body(fa.p_camera, fb.p_camera, 1 / (point_variance(fa, camera) + point_variance(fb, camera)));
    }
  };
  for_each_pair([&](const auto& pa, const auto& pb, double weight) {
    mean_a += weight * pa;
    mean_b += weight * pb;
    weights += weight;
  });
  mean_a /= weights;
  mean_b /= weights;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for_each_pair([&](const auto& pa, const auto& pb, double weight) {
    covariance += weight / weights * (pa - mean_a) * (pb - mean_b).transpose();
  });
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(covariance, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Vector3d signs(1, 1, (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1);
  Pose T = Pose::Identity();
  T.linear() = svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
  T.translation() = mean_a - T.linear() * mean_b;
  return orthonormalised(T);
}

namespace {

struct Projection {
  Eigen::Vector2d pixel;
  Eigen::Matrix<double, 2, 3> by_point;  // by the point in the depth camera
};

bool project(const Eigen::Vector3d& p_camera, const FeatureCamera& camera, Projection* projection) {
  const Eigen::Vector3d p = camera.T_colour_depth * p_camera;
  if (p.z() <= 0.05) return false;
  const auto fx = static_cast<double>(camera.camera.fx), fy = static_cast<double>(camera.camera.fy);
  projection->pixel = {fx * p.x() / p.z() + static_cast<double>(camera.camera.cx),
                       fy * p.y() / p.z() + static_cast<double>(camera.camera.cy)};
  Eigen::Matrix<double, 2, 3> by_colour;
  by_colour << fx / p.z(), 0, -fx * p.x() / (p.z() * p.z()), 0, fy / p.z(), -fy * p.y() / (p.z() * p.z());
  projection->by_point = by_colour * camera.T_colour_depth.linear();
  return true;
}

Eigen::Matrix<double, 3, 6> by_left_perturbation(const Eigen::Vector3d& p) {
  Eigen::Matrix<double, 3, 6> J;
  J << -skew(p), Eigen::Matrix3d::Identity();
  return J;
}

}  // namespace

bool is_explained(const Feature& a, const Feature& b, const Pose& T_a_b, const FeatureCamera& camera) {
  const Eigen::Vector3d p_camera = T_a_b * b.p_camera, p = camera.T_colour_depth * p_camera;
  if (p.z() <= 0.05) return false;
  const double gate_px = kGateSigmas * std::hypot(pixel_sigma(a), pixel_sigma(b)),
               gate_m = kGateSigmas * std::hypot(depth_sigma(a), depth_sigma(b));
  const double u = static_cast<double>(camera.camera.fx) * p.x() / p.z() +
                   static_cast<double>(camera.camera.cx),
               v = static_cast<double>(camera.camera.fy) * p.y() / p.z() +
                   static_cast<double>(camera.camera.cy);
  return std::abs(u - a.pixel.x()) < gate_px && std::abs(v - a.pixel.y()) < gate_px &&
         std::abs(p_camera.z() - a.p_camera.z()) < gate_m;
}

double FeatureEquations::trust(size_t matches) const {
  const double chi_square = std::max(1.0, squares / (5 * static_cast<double>(matches)));
  return 1 / (kCorrelation * chi_square);
}

FeatureEquations feature_equations(std::span<const Feature> a, std::span<const Feature> b,
                                   std::span<const FeatureMatch> matches, const Pose& T_a_b,
                                   const FeatureCamera& camera) {
  FeatureEquations sums;
  for (const FeatureMatch& match : matches) {
    const FeatureResidual residual =
        feature_residual(a[static_cast<size_t>(match.a)], b[static_cast<size_t>(match.b)], T_a_b, camera);
    if (!residual.is_visible) continue;
    const double squares = residual.r.squaredNorm();
    const double weight = 1 / (1 + squares / (5 * kGateSigmas));  // Cauchy
    sums.A += weight * residual.J.transpose() * residual.J;
    sums.b += weight * residual.J.transpose() * residual.r;
    sums.squares += weight * squares;
    sums.reprojection_squares += residual.r.head<4>().squaredNorm();
  }
  return sums;
}

namespace {

std::vector<FeatureMatch> inliers_of(std::span<const Feature> a, std::span<const Feature> b,
                                     std::span<const FeatureMatch> matches, const Pose& T_a_b,
                                     const FeatureCamera& camera) {
  std::vector<FeatureMatch> inliers;
  for (const FeatureMatch& match : matches) {
    const FeatureResidual residual =
        feature_residual(a[static_cast<size_t>(match.a)], b[static_cast<size_t>(match.b)], T_a_b, camera);
    if (residual.is_visible && residual.r.cwiseAbs().maxCoeff() < kGateSigmas) inliers.push_back(match);
  }
  return inliers;
}

}  // namespace

const char* to_string(FeatureStatus status) {
  switch (status) {
    case FeatureStatus::kOk:
      return "ok";
    case FeatureStatus::kTooFewFeatures:
      return "too few features";
    case FeatureStatus::kTooFewMatches:
      return "too few matches";
    case FeatureStatus::kTooFewInliers:
      return "too few inliers";
    case FeatureStatus::kUnconstrained:
      return "unconstrained";
    case FeatureStatus::kReprojectionError:
      return "reprojection error";
  }
  return "unknown";
}

std::vector<FeatureMatch> match_features(std::span<const Feature> a, std::span<const Feature> b) {
  std::vector<NearestTwo> nearest_a(a.size()), nearest_b(b.size());
  for (size_t i = 0; i < a.size(); ++i) {
    for (size_t j = 0; j < b.size(); ++j) {
      const int distance = descriptor_distance(a[i], b[j]);
      nearest_a[i].see(static_cast<int>(j), distance);
      nearest_b[j].see(static_cast<int>(i), distance);
    }
  }
  std::vector<FeatureMatch> matches;
  for (size_t i = 0; i < a.size(); ++i) {
    const NearestTwo& best = nearest_a[i];
    if (best.is_clear(kMaxRatio) && best.distance <= kMaxDistance &&
        nearest_b[static_cast<size_t>(best.index)].index == static_cast<int>(i))
      matches.push_back({static_cast<int>(i), best.index});
  }
  return matches;
}

FeatureResidual feature_residual(const Feature& a, const Feature& b, const Pose& T_a_b,
                                 const FeatureCamera& camera) {
  FeatureResidual residual;
  const Pose T_b_a = T_a_b.inverse();
  const Eigen::Vector3d b_in_a = T_a_b * b.p_camera, a_in_b = T_b_a * a.p_camera;
  Projection in_a, in_b;
  if (!project(b_in_a, camera, &in_a) || !project(a_in_b, camera, &in_b)) return residual;
  residual.is_visible = true;
  const double sigma_a = pixel_sigma(a), sigma_b = pixel_sigma(b);
  const double sigma_z = std::hypot(depth_sigma(a), depth_sigma(b));
  const Eigen::Matrix<double, 3, 6> moved = by_left_perturbation(b_in_a);
  residual.r.head<2>() = (in_a.pixel - a.pixel) / sigma_a;
  residual.J.topRows<2>() = in_a.by_point * moved / sigma_a;
  // T_b_a' = T_b_a exp(-xi).
  residual.r.segment<2>(2) = (in_b.pixel - b.pixel) / sigma_b;
  residual.J.middleRows<2>(2) = -in_b.by_point * T_b_a.linear() * by_left_perturbation(a.p_camera) / sigma_b;
  residual.r(4) = (b_in_a.z() - a.p_camera.z()) / sigma_z;
  residual.J.row(4) = moved.row(2) / sigma_z;
  return residual;
}

FeatureAlignment align_features(std::span<const Feature> a, std::span<const Feature> b,
                                const FeatureCamera& camera, int min_inliers) {
  FeatureAlignment result;
  const auto enough = static_cast<size_t>(min_inliers);
  if (a.size() < enough || b.size() < enough) return result;
  const std::vector<FeatureMatch> matches = match_features(a, b);
  result.matches = static_cast<int>(matches.size());
  result.status = FeatureStatus::kTooFewMatches;
  if (matches.size() < enough) return result;

  std::vector<FeatureMatch> inliers;
  for (const int i : ConsistencyGraph(a, b, matches, camera).largest_clique())
    inliers.push_back(matches[static_cast<size_t>(i)]);
  result.status = FeatureStatus::kTooFewInliers;
  result.inliers = static_cast<int>(inliers.size());
  if (inliers.size() < std::max<size_t>(3, enough / 2)) return result;
  const Pose T_a_b = absolute_orientation(a, b, inliers, camera);
  return refine_alignment(a, b, matches, T_a_b, std::move(inliers), camera, min_inliers);
}

FeatureAlignment refine_alignment(std::span<const Feature> a, std::span<const Feature> b,
                                  std::span<const FeatureMatch> matches, const Pose& T_a_b_guess,
                                  std::vector<FeatureMatch> inliers, const FeatureCamera& camera,
                                  int min_inliers) {
  FeatureAlignment result;
  result.status = FeatureStatus::kTooFewInliers;
  result.matches = static_cast<int>(matches.size());
  Pose T_a_b = T_a_b_guess;
  FeatureEquations sums;
  for (int round = 0; round <= kRounds; ++round) {
    for (int iteration = 0; iteration < kIterations; ++iteration) {
      sums = feature_equations(a, b, inliers, T_a_b, camera);
      const Matrix6d damped = sums.A + 1e-6 * Matrix6d::Identity();
      const Vector6d step = -damped.ldlt().solve(sums.b);
      if (!step.allFinite() || step.norm() > 1) break;
      T_a_b = orthonormalised(exp_se3(step) * T_a_b);
      if (step.norm() < 1e-6) break;
    }
    if (round < kRounds) inliers = inliers_of(a, b, matches, T_a_b, camera);
    result.inliers = static_cast<int>(inliers.size());
    if (static_cast<int>(inliers.size()) < min_inliers) return result;
  }
  result.T_a_b = T_a_b;
  const double count = static_cast<double>(inliers.size());
  result.information = sums.trust(inliers.size()) * sums.A;
  result.rms_px = kPixelSigma * std::sqrt(sums.reprojection_squares / (4 * count));
  result.status = FeatureStatus::kUnconstrained;
  if (!is_constrained(result.information, kMaxRotationSigma, kMaxTranslationSigma)) return result;
  result.status = FeatureStatus::kReprojectionError;
  if (result.rms_px > kPixelSigma * kMaxRms) return result;
  result.status = FeatureStatus::kOk;
  result.inlier_matches = std::move(inliers);
  return result;
}

}  // namespace kt
