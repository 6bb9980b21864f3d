// Tests of the pose between two frames' features: derivatives, known motions, outliers, the verdict.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/tracking/feature_aligner.h"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <functional>
#include <utility>

#include "gtest/gtest.h"

#include "shared/core/rng.h"
#include "tests/support/analytic_scene.h"
#include "tests/support/pose_matchers.h"

namespace kt::test {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kMinInliers = 15;
constexpr double kPixelSigma = 0.7;

FeatureCamera offset_camera() {
  return {{260, 255, 158, 121, 320, 240}, pose_of({2, -3, 4}, {-0.05, 0.01, 0.02})};
}

Vector2d project(const FeatureCamera& camera, const Vector3d& p_camera) {
  const Vector3d p = camera.T_colour_depth * p_camera;
  const PinholeParams& c = camera.camera;
  return {static_cast<double>(c.fx) * p.x() / p.z() + static_cast<double>(c.cx),
          static_cast<double>(c.fy) * p.y() / p.z() + static_cast<double>(c.cy)};
}

double uniform(uint64_t seed, uint64_t stream, uint64_t i, double low, double high) {
  return low + (high - low) * random_uniform(seed, stream, i);
}

/// Features of made-up points as two cameras see them; a's camera is the frame of the points.
struct Scenario {
  uint64_t seed = 1;
  int count = 120;
  FeatureCamera camera = offset_camera();
  Pose T_a_b = pose_of({3, -8, 5}, {0.1, -0.05, 0.15});
  double noise = 0;  // of pixels and depths, in their standard deviations
  int finest = 0, levels = 2;
  double nearest_m = 0.8, farthest_m = 4;
  std::function<Vector3d(uint64_t)> point = nullptr;  // of the i-th feature, instead of a random one
  std::function<double(uint64_t)> noise_of = nullptr;

  Vector3d random_point(uint64_t i) const {
    const double z = uniform(seed, 0, i, nearest_m, farthest_m);
    return {uniform(seed, 1, i, -0.6, 0.6) * z, uniform(seed, 2, i, -0.45, 0.45) * z, z};
  }
  // What is measured of a true point: its pixel, and a depth along the ray of that pixel.
  Feature seen(const Vector3d& p_true, uint64_t i, uint64_t stream) const {
    Feature feature;
    feature.level = finest + static_cast<int>(random_bits(seed, 3, i) % static_cast<uint64_t>(levels));
    for (size_t word = 0; word < feature.descriptor.size(); ++word)
      feature.descriptor[word] = random_bits(seed, 10 + word, i);
    const auto normal = [&](uint64_t which) {
      return (noise_of ? noise_of(i) : noise) * random_normal(seed, stream + which, i);
    };
    const Vector3d p_colour = camera.T_colour_depth * p_true;
    const double sigma = kPixelSigma * (1 << feature.level);
    feature.pixel = project(camera, p_true) + sigma * Vector2d(normal(0), normal(1));
    const double z =
        p_colour.z() + static_cast<double>(depth_sigma_m(static_cast<float>(p_true.z()))) * normal(2);
    const PinholeParams& c = camera.camera;
    const Vector3d ray((feature.pixel.x() - static_cast<double>(c.cx)) / static_cast<double>(c.fx),
                       (feature.pixel.y() - static_cast<double>(c.cy)) / static_cast<double>(c.fy), 1);
    feature.p_camera = camera.T_colour_depth.inverse() * (z * ray);
    return feature;
  }
  std::pair<std::vector<Feature>, std::vector<Feature>> features() const {
    std::pair<std::vector<Feature>, std::vector<Feature>> both;
    for (uint64_t i = 0; i < static_cast<uint64_t>(count); ++i) {
      const Vector3d p = point ? point(i) : random_point(i);
      both.first.push_back(seen(p, i, 20));
      both.second.push_back(seen(T_a_b.inverse() * p, i, 30));
    }
    return both;
  }
  FeatureAlignment aligned() const {
    const auto [a, b] = features();
    return align_features(a, b, camera, kMinInliers);
  }
};

// The first `wrong` features of b look like others of a.
void mismatch(std::vector<Feature>* b, size_t wrong) {
  const Feature first = b->front();
  for (size_t i = 0; i + 1 < wrong; ++i) (*b)[i].descriptor = (*b)[i + 1].descriptor;
  (*b)[wrong - 1].descriptor = first.descriptor;
}

TEST(FeatureResidual, JacobianEqualsCentralDifferences) {
  Scenario scenario;
  scenario.noise = 3;
  scenario.levels = 3;
  constexpr double kStep = 1e-6;
  for (uint64_t trial = 0; trial < 10; ++trial) {
    scenario.seed = trial;
    scenario.T_a_b = pose_of(10 * Vector3d(random_normal(trial, 50, 0), random_normal(trial, 50, 1), 1.0),
                             0.2 * Vector3d(random_normal(trial, 51, 0), 1.0, random_normal(trial, 51, 1)));
    const auto [a, b] = scenario.features();
    for (size_t i = 0; i < 20; ++i) {
      const auto at = [&, &a = a, &b = b](const Pose& T) {
        return feature_residual(a[i], b[i], T, scenario.camera);
      };
      const FeatureResidual here = at(scenario.T_a_b);
      if (!here.is_visible) continue;
      for (int k = 0; k < 6; ++k) {
        const Vector6d step = kStep * Vector6d::Unit(k);
        const Eigen::Matrix<double, 5, 1> numeric =
            (at(exp_se3(step) * scenario.T_a_b).r - at(exp_se3(-step) * scenario.T_a_b).r) / (2 * kStep);
        EXPECT_LT((here.J.col(k) - numeric).norm(), 1e-5 * (1 + numeric.norm())) << k;
      }
    }
  }
}

TEST(FeatureResidual, VanishesAtTheTruth) {
  const Scenario scenario;
  const auto [a, b] = scenario.features();
  for (size_t i = 0; i < a.size(); ++i) {
    const FeatureResidual residual = feature_residual(a[i], b[i], scenario.T_a_b, scenario.camera);
    EXPECT_TRUE(residual.is_visible);
    EXPECT_LT(residual.r.norm(), 1e-9);
  }
}

// One standard deviation of each part.
TEST(FeatureResidual, CountsStandardDeviations) {
  Scenario scenario;
  scenario.T_a_b = Pose::Identity();
  auto [a, b] = scenario.features();
  for (size_t i = 0; i < a.size(); ++i) {
    a[i].pixel.x() += kPixelSigma * (1 << a[i].level);
    b[i].pixel.y() -= kPixelSigma * (1 << b[i].level);
    const auto r = feature_residual(a[i], b[i], scenario.T_a_b, scenario.camera).r;
    EXPECT_LT((r.head<4>() - Eigen::Vector4d(-1, 0, 0, 1)).norm(), 1e-9);
    const double sigma = static_cast<double>(depth_sigma_m(static_cast<float>(a[i].p_camera.z())));
    b[i].p_camera.z() += sigma;
    EXPECT_NEAR(feature_residual(a[i], b[i], scenario.T_a_b, scenario.camera).r(4), 1 / std::sqrt(2), 0.02);
  }
}

TEST(FeatureResidual, IsNoneBehindACamera) {
  const Scenario scenario;
  const auto [a, b] = scenario.features();
  EXPECT_FALSE(feature_residual(a[0], b[0], pose_of({0, 180, 0}, {0, 0, 0}), scenario.camera).is_visible);
  EXPECT_FALSE(feature_residual(a[0], b[0], pose_of({0, 0, 0}, {0, 0, -5}), scenario.camera).is_visible);
}

TEST(MatchFeatures, PairsWhatLooksAlikeAndNothingAmbiguous) {
  const Scenario scenario;
  auto [a, b] = scenario.features();
  std::swap(b[3], b[7]);
  b[10].descriptor = b[11].descriptor;  // two that look like a[11], none like a[10]
  for (size_t word = 0; word < 2; ++word) b[20].descriptor[word] = ~b[20].descriptor[word];
  const std::vector<FeatureMatch> matches = match_features(a, b);
  EXPECT_EQ(matches.size(), a.size() - 3);
  for (const FeatureMatch& match : matches) {
    EXPECT_EQ(match.b, match.a == 3 ? 7 : match.a == 7 ? 3 : match.a);
    EXPECT_TRUE(match.a != 10 && match.a != 11 && match.a != 20);
  }
}

TEST(AlignFeatures, FindsKnownMotionsExactly) {
  Scenario scenario;
  for (const Pose& motion :
       {Pose::Identity(), pose_of({3, -8, 5}, {0.1, -0.05, 0.15}), pose_of({0, 0, 170}, {0, 0, 0}),
        pose_of({-20, 25, 10}, {-0.4, 0.2, 0.3}), pose_of({0, 0, 0}, {0, 0, 0.5})}) {
    scenario.T_a_b = motion;
    const FeatureAlignment result = scenario.aligned();
    EXPECT_EQ(result.status, FeatureStatus::kOk);
    EXPECT_EQ(result.matches, scenario.count);
    EXPECT_EQ(result.inliers, scenario.count);
    EXPECT_LT(result.rms_px, 1e-3);
    EXPECT_POSE_NEAR(result.T_a_b, motion, 1e-4, 1e-5);
  }
}

TEST(AlignFeatures, ToleratesNoise) {
  Scenario scenario;
  scenario.noise = 1;
  for (scenario.seed = 0; scenario.seed < 5; ++scenario.seed) {
    const FeatureAlignment result = scenario.aligned();
    EXPECT_EQ(result.status, FeatureStatus::kOk);
    EXPECT_GT(result.inliers, scenario.count * 8 / 10);
    EXPECT_NEAR(result.rms_px, kPixelSigma * std::sqrt(2), 0.25) << "of the points of both frames";
    EXPECT_POSE_NEAR(result.T_a_b, scenario.T_a_b, 0.2, 0.01);
  }
}

TEST(AlignFeatures, FindsTheMotionAmongSeventyPercentWrongMatches) {
  Scenario scenario;
  scenario.count = 200;
  scenario.noise = 1;
  for (scenario.seed = 0; scenario.seed < 5; ++scenario.seed) {
    auto [a, b] = scenario.features();
    mismatch(&b, 140);
    const FeatureAlignment result = align_features(a, b, scenario.camera, kMinInliers);
    EXPECT_EQ(result.status, FeatureStatus::kOk);
    EXPECT_EQ(result.matches, 200);
    EXPECT_GT(result.inliers, 45);
    EXPECT_LT(result.inliers, 70);
    EXPECT_POSE_NEAR(result.T_a_b, scenario.T_a_b, 0.3, 0.015);
  }
}

// At 5 m the noise of depth is 4 cm, at 1 m 2 mm.
TEST(AlignFeatures, FarNoisyPointsDoNotBreakNearOnes) {
  Scenario scenario;
  const auto is_far = [](uint64_t i) { return i % 3 != 0; };
  scenario.point = [&](uint64_t i) {
    const Vector3d p = scenario.random_point(i);
    return Vector3d(p * ((is_far(i) ? 5.0 : 1.0) / p.z()));
  };
  scenario.noise_of = [&](uint64_t i) { return is_far(i) ? 1.0 : 0.2; };
  scenario.levels = 1;
  for (scenario.seed = 0; scenario.seed < 5; ++scenario.seed) {
    const FeatureAlignment result = scenario.aligned();
    EXPECT_EQ(result.status, FeatureStatus::kOk);
    EXPECT_GT(result.inliers, 90) << "far ones count too";
    EXPECT_POSE_NEAR(result.T_a_b, scenario.T_a_b, 0.1, 0.003);
  }
}

TEST(AlignFeatures, WhatIsNoiseFarAwayIsAnErrorNearBy) {
  const auto inliers_with_half_farther = [](double z, double error) {
    Scenario scenario;
    scenario.nearest_m = scenario.farthest_m = z;
    scenario.T_a_b = Pose::Identity();
    auto [a, b] = scenario.features();
    for (size_t i = 0; i < b.size(); i += 2) b[i].p_camera *= 1 + error / z;
    return align_features(a, b, scenario.camera, kMinInliers).inliers;
  };
  EXPECT_EQ(inliers_with_half_farther(5, 0.06), 120);
  EXPECT_EQ(inliers_with_half_farther(1, 0.06), 60);
}

TEST(AlignFeatures, SaysWhereThereAreTooFewFeatures) {
  const auto [a, b] = Scenario().features();
  const std::vector<Feature> few(a.begin(), a.begin() + kMinInliers - 1);
  const FeatureCamera camera = offset_camera();
  EXPECT_EQ(align_features(few, b, camera, kMinInliers).status, FeatureStatus::kTooFewFeatures);
  EXPECT_EQ(align_features(a, few, camera, kMinInliers).status, FeatureStatus::kTooFewFeatures);
  EXPECT_EQ(align_features({}, {}, camera, kMinInliers).status, FeatureStatus::kTooFewFeatures);
}

TEST(AlignFeatures, SaysWhereTooFewMatch) {
  Scenario scenario, other;
  other.seed = 2;
  const FeatureAlignment result =
      align_features(scenario.features().first, other.features().second, scenario.camera, kMinInliers);
  EXPECT_EQ(result.status, FeatureStatus::kTooFewMatches);
  EXPECT_LT(result.matches, kMinInliers);
}

TEST(AlignFeatures, SaysWhereNoMotionExplainsTheMatches) {
  Scenario scenario;
  scenario.noise = 1;
  for (scenario.seed = 0; scenario.seed < 5; ++scenario.seed) {
    auto [a, b] = scenario.features();
    mismatch(&b, b.size());
    const FeatureAlignment result = align_features(a, b, scenario.camera, kMinInliers);
    EXPECT_EQ(result.status, FeatureStatus::kTooFewInliers);
    EXPECT_EQ(result.matches, scenario.count);
    EXPECT_LT(result.inliers, kMinInliers);
  }
}

TEST(AlignFeatures, SaysWhereADirectionIsOpen) {
  Scenario cluster;  // tells where it is, but not how it is turned
  cluster.point = [&](uint64_t i) {
    return Vector3d(Vector3d(0.3, -0.2, 3) + 0.005 * (cluster.random_point(i) - Vector3d(0, 0, 2)));
  };
  EXPECT_EQ(cluster.aligned().status, FeatureStatus::kUnconstrained);
  Scenario line;  // all but the turn about it
  line.point = [](uint64_t i) { return Vector3d(-1 + static_cast<double>(i) / 60, 0.1, 2); };
  EXPECT_EQ(line.aligned().status, FeatureStatus::kUnconstrained);
}

// Points that agree, at pixels that disagree with them: four at each place, which pull apart in balance and
// each within its gate.
TEST(AlignFeatures, SaysWhereReprojectionsAreBad) {
  Scenario scenario;
  scenario.levels = 1;
  scenario.point = [&](uint64_t i) { return scenario.random_point(i / 4); };
  auto [a, b] = scenario.features();
  for (size_t i = 0; i < a.size(); ++i) {
    const double by_u = i % 4 < 2 ? 1 : -1, by_v = i % 2 == 0 ? 1 : -1;
    a[i].pixel += 2.8 * kPixelSigma * Vector2d(by_u, by_v);
    b[i].pixel += 2.8 * kPixelSigma * Vector2d(by_u, -by_v);
  }
  const FeatureAlignment result = align_features(a, b, scenario.camera, kMinInliers);
  EXPECT_EQ(result.status, FeatureStatus::kReprojectionError);
  EXPECT_EQ(result.inliers, scenario.count);
  EXPECT_NEAR(result.rms_px, 2.8 * kPixelSigma, 0.01);
}

TEST(AlignFeatures, NamesEveryStatus) {
  EXPECT_STREQ(to_string(FeatureStatus::kOk), "ok");
  EXPECT_STREQ(to_string(FeatureStatus::kTooFewFeatures), "too few features");
  EXPECT_STREQ(to_string(FeatureStatus::kTooFewMatches), "too few matches");
  EXPECT_STREQ(to_string(FeatureStatus::kTooFewInliers), "too few inliers");
  EXPECT_STREQ(to_string(FeatureStatus::kUnconstrained), "unconstrained");
  EXPECT_STREQ(to_string(FeatureStatus::kReprojectionError), "reprojection error");
}

// Normalised estimation error squared: 6 on average for a consistent covariance, less for a cautious one.
TEST(AlignFeatures, InformationIsPositiveDefiniteAndConsistent) {
  Scenario scenario;
  scenario.noise = 1;
  constexpr uint64_t kTrials = 50;
  double sum = 0;
  for (scenario.seed = 100; scenario.seed < 100 + kTrials; ++scenario.seed) {
    const FeatureAlignment result = scenario.aligned();
    ASSERT_EQ(result.status, FeatureStatus::kOk);
    const Matrix6d& information = result.information;
    EXPECT_LT((information - information.transpose()).norm(), 1e-12 * information.norm());
    EXPECT_GT(Eigen::SelfAdjointEigenSolver<Matrix6d>(information).eigenvalues()(0), 0);
    const Vector6d error = log_se3(result.T_a_b * scenario.T_a_b.inverse());
    sum += error.dot(information * error);
  }
  const double nees = sum / kTrials;
  RecordProperty("nees", std::to_string(nees));
  EXPECT_LT(nees, 18);
  EXPECT_GT(nees, 2);
}

TEST(AlignFeatures, GivesTheSameBitsEachTime) {
  Scenario scenario;
  scenario.noise = 1;
  auto [a, b] = scenario.features();
  mismatch(&b, 60);
  const FeatureAlignment first = align_features(a, b, scenario.camera, kMinInliers),
                         again = align_features(a, b, scenario.camera, kMinInliers);
  EXPECT_EQ(first.T_a_b.matrix(), again.T_a_b.matrix());
  EXPECT_EQ(first.information, again.information);
  EXPECT_EQ(first.inliers, again.inliers);
}

TEST(AlignFeatures, FindsTheMotionBetweenTwoRenderedFrames) {
  Calibration calibration = small_calibration(2);
  calibration.colour = {480, 360, 384, 384, 239.5, 179.5, {}};
  calibration.T_colour_depth = pose_of({0.3, -0.5, 0.2}, {-0.03, 0.01, 0});
  const exec::Device device = exec::Device::cpu(1);
  Preprocessor preprocessor(device, calibration, {});
  FeatureDetector detector(device, calibration);
  const FeatureCamera camera{calibration.colour.pinhole().half(), calibration.T_colour_depth};
  const Pose T_world_a = pose_of({3, -5, 2}, {0.1, -0.1, 0.1}),
             T_a_b = pose_of({3, -14, 4}, {0.15, -0.05, 0.12});
  const auto features_at = [&](const Pose& T_world_camera, uint64_t seed) {
    return detector.detect(
        preprocessor.process(render(furnished_room(), calibration, T_world_camera,
                                    {.noise_sigmas = 0.5, .seed = seed, .blotches_m = 0.12})));
  };
  const FeatureAlignment result =
      align_features(features_at(T_world_a, 1), features_at(T_world_a * T_a_b, 2), camera, kMinInliers);
  EXPECT_EQ(result.status, FeatureStatus::kOk);
  EXPECT_GT(result.inliers, 30);
  EXPECT_POSE_NEAR(result.T_a_b, T_a_b, 0.5, 0.01);
  const Vector6d error = log_se3(result.T_a_b * T_a_b.inverse());
  EXPECT_LT(error.dot(result.information * error), 22.5) << "beyond this lies one in a thousand";
}

}  // namespace
}  // namespace kt::test
