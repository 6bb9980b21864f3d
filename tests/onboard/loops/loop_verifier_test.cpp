// Tests of the verdicts on keyframes made by hand.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/loops/loop_verifier.h"

#include <algorithm>
#include <cmath>

#include "gtest/gtest.h"

#include "tests/onboard/loops/random_descriptors.h"
#include "tests/support/analytic_scene.h"
#include "tests/support/pose_matchers.h"

namespace kt::test {
namespace {

const DescriptorKind kKind{"surf64", 64, DescriptorMetric::kEuclidean};
const Calibration kCalibration = small_calibration(4);

// Of a quarter of the resolution, in millimetres: how keyframes keep their depth.
Calibration quarter_calibration() {
  Calibration calibration = small_calibration();
  calibration.depth_unit_m = 0.001;
  return calibration;
}

struct Pair {
  Place from, to;
  Pose T_from_to = Pose::Identity();
};

// The keypoint of `p_world` in the camera; false where that does not see it.
bool see(const AnalyticScene& scene, const Pose& T_world_camera, const Eigen::Vector3d& p_world,
         Keyframe& keyframe) {
  const Eigen::Vector3d p = T_world_camera.inverse() * p_world;
  if (p.z() < 0.1) return false;
  const Eigen::Vector2d pixel = kCalibration.colour.project(p);
  if (pixel.x() < 0 || pixel.y() < 0 || pixel.x() > kCalibration.colour.width - 1 ||
      pixel.y() > kCalibration.colour.height - 1)
    return false;
  const auto hit = scene.trace(T_world_camera.translation(), p_world - T_world_camera.translation());
  if (!hit || (hit->p_world - p_world).norm() > 1e-6) return false;
  keyframe.u_px.push_back(static_cast<float>(pixel.x()));
  keyframe.v_px.push_back(static_cast<float>(pixel.y()));
  keyframe.scale_px.push_back(3);
  keyframe.p_camera.push_back(
      {static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z())});
  return true;
}

void forget_last(Keyframe& keyframe) {
  keyframe.u_px.pop_back();
  keyframe.v_px.pop_back();
  keyframe.scale_px.pop_back();
  keyframe.p_camera.pop_back();
}

// Where in the first image features may lie, in shares of its size.
struct Region {
  double u_begin = 0, u_end = 1, v_begin = 0, v_end = 1;
};

// Two views of a scene with up to `count` features that both see; equal features have equal descriptors, but
// for a share of wrong ones.
Pair pair_of(const AnalyticScene& scene, const Pose& T_world_from, const Pose& T_world_to, int count,
             double wrong_share = 0, const Region& region = {}) {
  Pair pair;
  pair.T_from_to = T_world_from.inverse() * T_world_to;
  Keyframe &from = pair.from.keyframe, &to = pair.to.keyframe;
  for (uint64_t draw = 0; draw < 5000 && static_cast<int>(from.u_px.size()) < count; ++draw) {
    const auto between = [&](double low, double high, uint64_t stream) {
      return low + (high - low) * random_uniform(11, stream, draw);
    };
    const double u = between(region.u_begin, region.u_end, 0) * (kCalibration.colour.width - 1),
                 v = between(region.v_begin, region.v_end, 1) * (kCalibration.colour.height - 1);
    const auto hit = scene.trace(T_world_from.translation(),
                                 T_world_from.linear() * ray_of_pixel(kCalibration.colour, u, v));
    if (!hit || !see(scene, T_world_from, hit->p_world, from)) continue;
    if (!see(scene, T_world_to, hit->p_world, to)) forget_last(from);
  }
  const size_t found = from.u_px.size();
  EXPECT_EQ(found, static_cast<size_t>(count)) << "the views share too little";
  from.descriptors = to.descriptors = random_descriptors(kKind, found, 5);
  const auto wrong = static_cast<std::ptrdiff_t>(wrong_share * static_cast<double>(found));
  if (wrong > 0)  // features with the descriptor of their neighbour
    std::rotate(to.descriptors.begin(), to.descriptors.begin() + kKind.bytes,
                to.descriptors.begin() + wrong * kKind.bytes);
  pair.from.nodes = pair.to.nodes = std::vector<int32_t>(found, 0);
  from.depth = render(scene, quarter_calibration(), T_world_from).depth;
  to.depth = render(scene, quarter_calibration(), T_world_to).depth;
  from.sequence = 40;
  to.sequence = 900;
  to.timestamp_us = 31'000'000;
  return pair;
}

const Pose kFrom = Pose::Identity(), kTo = pose_of({2, -7, 1}, {0.15, -0.05, 0.1});

LoopClosure verify(const Pair& pair, const VerificationConfig& config = {}) {
  return LoopVerifier(kCalibration, kKind, config).verify(pair.from, pair.to);
}

void expect_finite(const LoopClosure& loop) {
  EXPECT_TRUE(loop.T_from_to.matrix().allFinite());
  EXPECT_TRUE(loop.information.allFinite());
  for (const float value : {loop.similarity, loop.reprojection_px, loop.overlap, loop.surface_rms_m})
    EXPECT_TRUE(std::isfinite(value));
  for (const auto* points : {&loop.p_from, &loop.p_to}) {
    for (const Vec3f& p : *points)
      EXPECT_TRUE(std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z));
  }
}

void expect_verdict(const LoopClosure& loop, LoopVerdict verdict) {
  EXPECT_EQ(loop.verdict, verdict) << to_string(loop.verdict) << " instead of " << to_string(verdict) << ": "
                                   << loop.matches << " matches, " << loop.p_from.size()
                                   << " inliers, overlap " << loop.overlap << ", surface "
                                   << loop.surface_rms_m;
  expect_finite(loop);
}

void expect_inliers_agree(const LoopClosure& loop) {
  ASSERT_EQ(loop.p_from.size(), loop.p_to.size());
  for (size_t i = 0; i < loop.p_from.size(); ++i) {
    const Vec3f moved = to_rigid3f(loop.T_from_to) * loop.p_to[i];
    EXPECT_LT(std::sqrt(squared_norm(moved - loop.p_from[i])), 0.005f);
  }
}

TEST(LoopVerifier, MeasuresTwoViewsOfOnePlace) {
  const Pair pair = pair_of(furnished_room(), kFrom, kTo, 80);
  const LoopClosure loop = verify(pair);
  expect_verdict(loop, LoopVerdict::kAccepted);
  EXPECT_POSE_NEAR(loop.T_from_to, pair.T_from_to, 0.1, 0.002);
  EXPECT_EQ(loop.from, 40);
  EXPECT_EQ(loop.to, 900);
  EXPECT_EQ(loop.timestamp_us, 31'000'000);
  EXPECT_EQ(loop.matches, 80);
  EXPECT_EQ(loop.p_from.size(), 80u);
  expect_inliers_agree(loop);
  EXPECT_LT(loop.reprojection_px, 0.2f);
  EXPECT_LT(loop.surface_rms_m, 0.005f);
  EXPECT_GT(loop.overlap, 0.6f);
  EXPECT_LE(loop.overlap, 1.0f);
  EXPECT_TRUE(loop.information.isApprox(loop.information.transpose(), 1e-12));
}

TEST(LoopVerifier, MeasuresDespiteWrongMatches) {
  const Pair pair = pair_of(furnished_room(), kFrom, kTo, 120, 0.5);
  const LoopClosure loop = verify(pair);
  expect_verdict(loop, LoopVerdict::kAccepted);
  EXPECT_POSE_NEAR(loop.T_from_to, pair.T_from_to, 0.1, 0.002);
  EXPECT_EQ(loop.matches, 120);
  EXPECT_GE(loop.p_from.size(), 60u);
  EXPECT_LT(loop.p_from.size(), 66u);
}

TEST(LoopVerifier, MeasuresWithColourBesideDepth) {
  Calibration calibration = kCalibration;
  calibration.T_colour_depth = pose_of({0, 1, 0}, {-0.05, 0.002, 0.001});
  Pair pair = pair_of(furnished_room(), kFrom, kTo, 80);
  for (Keyframe* keyframe : {&pair.from.keyframe, &pair.to.keyframe}) {
    for (size_t i = 0; i < keyframe->p_camera.size(); ++i) {
      const Vec3f p = keyframe->p_camera[i];
      const Eigen::Vector2d pixel = calibration.colour.project(calibration.T_colour_depth * to_eigen(p));
      keyframe->u_px[i] = static_cast<float>(pixel.x());
      keyframe->v_px[i] = static_cast<float>(pixel.y());
    }
  }
  const LoopClosure loop = LoopVerifier(calibration, kKind, {}).verify(pair.from, pair.to);
  expect_verdict(loop, LoopVerdict::kAccepted);
  EXPECT_POSE_NEAR(loop.T_from_to, pair.T_from_to, 0.1, 0.002);
  EXPECT_EQ(loop.p_from.size(), 80u);
}

TEST(LoopVerifier, RejectsTooFewMatches) {
  expect_verdict(verify(pair_of(furnished_room(), kFrom, kTo, 19)), LoopVerdict::kTooFewMatches);
  expect_verdict(verify(pair_of(furnished_room(), kFrom, kTo, 20)), LoopVerdict::kAccepted);
  // Features without a point do not count.
  Pair pair = pair_of(furnished_room(), kFrom, kTo, 20);
  pair.to.keyframe.p_camera[3] = {0, 0, 0};
  const LoopClosure loop = verify(pair);
  expect_verdict(loop, LoopVerdict::kTooFewMatches);
  EXPECT_EQ(loop.matches, 19);
}

TEST(LoopVerifier, RejectsMatchesThatNoMotionExplains) {
  const LoopClosure loop = verify(pair_of(furnished_room(), kFrom, kTo, 80, 1.0));
  expect_verdict(loop, LoopVerdict::kTooFewInliers);
  EXPECT_EQ(loop.matches, 80);
  // A share of them is asked for as well as a number.
  const Pair pair = pair_of(furnished_room(), kFrom, kTo, 100, 0.7);
  expect_verdict(verify(pair), LoopVerdict::kTooFewInliers);
  VerificationConfig config;
  config.min_inlier_share = 0.25;
  expect_verdict(verify(pair, config), LoopVerdict::kAccepted);
  config.min_inliers = 40;
  expect_verdict(verify(pair, config), LoopVerdict::kTooFewInliers);
}

TEST(LoopVerifier, RejectsLittleOverlap) {
  const Pose turned = pose_of({0, 50, 0}, {0, 0, 0});
  const LoopClosure loop = verify(pair_of(furnished_room(), kFrom, turned, 80, 0, {.u_begin = 0.6}));
  expect_verdict(loop, LoopVerdict::kLittleOverlap);
  EXPECT_GT(loop.overlap, 0.02f);
}

TEST(LoopVerifier, RejectsAnotherSurface) {
  Pair pair = pair_of(furnished_room(), kFrom, kTo, 80);
  // The features stay, but something large stands before them.
  const AnalyticScene changed = furnished_room().with(Box{{-0.4, -0.3, 1.2}, {0.3, 0.3, 1.3}});
  pair.to.keyframe.depth = render(changed, quarter_calibration(), kTo).depth;
  const LoopClosure loop = verify(pair);
  expect_verdict(loop, LoopVerdict::kSurfaceMismatch);
  EXPECT_GE(loop.overlap, 0.25f);
}

TEST(LoopVerifier, RejectsAMotionThatNothingTellsAlongAWall) {
  const AnalyticScene wall({Plane{{0, 0, -1}, -2.5}});
  expect_verdict(verify(pair_of(wall, kFrom, kTo, 80)), LoopVerdict::kAccepted);
  // On a line, or within 3 cm, three features never tell a motion.
  expect_verdict(verify(pair_of(wall, kFrom, kTo, 30, 0, {0.1, 0.9, 0.5, 0.5})), LoopVerdict::kTooFewInliers);
  expect_verdict(verify(pair_of(wall, kFrom, kTo, 30, 0, {0.495, 0.505, 0.495, 0.505})),
                 LoopVerdict::kTooFewInliers);
  // Within 12 cm they say too little.
  expect_verdict(verify(pair_of(wall, kFrom, kTo, 30, 0, {0.48, 0.52, 0.48, 0.52})),
                 LoopVerdict::kUnconstrained);
  expect_verdict(verify(pair_of(wall, kFrom, kTo, 30, 0, {0.4, 0.6, 0.4, 0.6})), LoopVerdict::kAccepted);
}

TEST(LoopVerifier, KeyframesWithoutFeaturesOrDepthAreNoProof) {
  const Pair pair = pair_of(furnished_room(), kFrom, kTo, 80);
  expect_verdict(verify({{}, {}, {}}), LoopVerdict::kTooFewMatches);
  expect_verdict(verify({pair.from, {}, {}}), LoopVerdict::kTooFewMatches);
  expect_verdict(verify({{}, pair.to, {}}), LoopVerdict::kTooFewMatches);
  for (const bool first : {true, false}) {
    for (const bool has_image : {true, false}) {  // all 0, or none
      Pair blind = pair;
      Image<uint16_t>& depth = (first ? blind.from : blind.to).keyframe.depth;
      depth = has_image ? Image<uint16_t>(depth.width(), depth.height()) : Image<uint16_t>();
      expect_verdict(verify(blind), LoopVerdict::kLittleOverlap);
    }
  }
}

TEST(LoopVerifier, RemembersNothingOfEarlierPairs) {
  const std::vector<Pair> pairs = {pair_of(furnished_room(), kFrom, kTo, 120, 0.5),
                                   pair_of(furnished_room(), kFrom, kTo, 80, 1.0),
                                   pair_of(room_corner(), kFrom, kTo, 60)};
  LoopVerifier verifier(kCalibration, kKind, {});
  for (const size_t i : {0, 0, 1, 2, 0, 2, 1, 1}) {
    const LoopClosure loop = verifier.verify(pairs[i].from, pairs[i].to), fresh = verify(pairs[i]);
    EXPECT_EQ(loop.verdict, fresh.verdict);
    EXPECT_EQ(loop.T_from_to.matrix(), fresh.T_from_to.matrix());
    EXPECT_EQ(loop.information, fresh.information);
    EXPECT_EQ(loop.matches, fresh.matches);
    EXPECT_EQ(loop.reprojection_px, fresh.reprojection_px);
    EXPECT_EQ(loop.overlap, fresh.overlap);
    EXPECT_EQ(loop.surface_rms_m, fresh.surface_rms_m);
    EXPECT_EQ(loop.p_from.size(), fresh.p_from.size());
  }
}

}  // namespace
}  // namespace kt::test
