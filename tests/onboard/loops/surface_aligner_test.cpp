// Tests of the alignment and comparison of two depth images of made scenes.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/loops/surface_aligner.h"

#include "gtest/gtest.h"

#include "tests/support/analytic_scene.h"
#include "tests/support/pose_matchers.h"

namespace kt::test {
namespace {

const auto kNothingElse = [](const Pose&, Matrix6d*, Vector6d*) {};

Calibration in_millimetres() {
  Calibration calibration = small_calibration();
  calibration.depth_unit_m = 0.001;
  return calibration;
}
const PinholeParams kCamera = in_millimetres().depth.pinhole();

KeptPlaceSurface surface_of(const AnalyticScene& scene, const Pose& T_world_camera) {
  return {exec::Device::cpu(1), render(scene, in_millimetres(), T_world_camera).depth, kCamera};
}

AnalyticScene wall_at(double z_m) { return AnalyticScene({Plane{{0, 0, -1}, -z_m}}); }

TEST(SurfaceAligner, PullsARoughGuessToTheTruth) {
  const Pose T_world_from = Pose::Identity(), T_world_to = pose_of({3, -8, 2}, {0.15, -0.05, 0.1});
  const Pose T_from_to = T_world_from.inverse() * T_world_to;
  for (const AnalyticScene& scene : {furnished_room(), room_corner()}) {
    const KeptPlaceSurface from = surface_of(scene, T_world_from), to = surface_of(scene, T_world_to);
    SurfaceAligner aligner(kCamera);
    for (const Eigen::Vector3d& axis : {Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(0, 1, 0),
                                        Eigen::Vector3d(0, 0, 1), Eigen::Vector3d(-0.6, 0.64, 0.48)}) {
      const Pose guess = pose_of(2 * axis, 0.03 * axis.reverse()) * T_from_to;
      const SurfaceAlignment aligned = aligner.align(from, to, guess, kNothingElse);
      EXPECT_POSE_NEAR(aligned.T_from_to, T_from_to, 0.1, 0.001);
      EXPECT_GT(aligned.pairs, to.points_seen / 2);
      EXPECT_TRUE(aligned.information.allFinite());
    }
  }
}

TEST(SurfaceAligner, LeavesOpenWhatTheSurfaceLeavesOpenAndTheOthersDecide) {
  const KeptPlaceSurface from = surface_of(wall_at(2), Pose::Identity()),
                         to = surface_of(wall_at(1.97), Pose::Identity());
  SurfaceAligner aligner(kCamera);
  const Pose truth = pose_of({0, 0, 0}, {0, 0, 0.03});
  const SurfaceAlignment alone = aligner.align(from, to, Pose::Identity(), kNothingElse);
  EXPECT_POSE_NEAR(alone.T_from_to, truth, 0.05, 0.001);
  EXPECT_NEAR(alone.information(3, 3), 0, 1e-3);
  EXPECT_GT(alone.information(5, 5), 1e4);
  const auto to_the_right = [](const Pose& T, Matrix6d* A, Vector6d* b) {
    (*A)(3, 3) += 100;
    (*b)(3) += 100 * (T.translation().x() - 0.02);
  };
  const SurfaceAlignment together = aligner.align(from, to, Pose::Identity(), to_the_right);
  EXPECT_POSE_NEAR(together.T_from_to, pose_of({0, 0, 0}, {0.02, 0, 0.03}), 0.05, 0.001);
  EXPECT_NEAR(together.information(3, 3), 0, 1e-3);  // of the surfaces alone
}

TEST(SurfaceAligner, NothingInCommonLeavesTheGuess) {
  const KeptPlaceSurface wall = surface_of(wall_at(2), Pose::Identity()),
                         nothing = surface_of(AnalyticScene(), Pose::Identity());
  SurfaceAligner aligner(kCamera);
  const Pose guess = pose_of({1, 2, 3}, {0.1, 0.2, 0.3});
  for (const auto& [from, to] : {std::pair(&wall, &nothing), std::pair(&nothing, &wall)}) {
    const SurfaceAlignment aligned = aligner.align(*from, *to, guess, kNothingElse);
    EXPECT_POSE_NEAR(aligned.T_from_to, guess, 1e-6, 1e-9);
    EXPECT_EQ(aligned.pairs, 0);
    EXPECT_TRUE(aligned.information.isZero());
  }
}

TEST(SurfaceAgreement, OfOneViewIsComplete) {
  const KeptPlaceSurface surface = surface_of(furnished_room(), Pose::Identity());
  ASSERT_GT(surface.points_seen, 15'000);
  const SurfaceAgreement counts = SurfaceAligner::agreement(surface, surface, Pose::Identity());
  EXPECT_EQ(counts.points, surface.points_seen);
  EXPECT_EQ(counts.same, surface.points_seen);
  EXPECT_EQ(counts.turned, 0);
  EXPECT_EQ(counts.before, 0);
  EXPECT_NEAR(counts.squares_m2, 0, 1e-9);
  EXPECT_EQ(counts.overlap(), 1);
  EXPECT_EQ(counts.conflict(), 0);
  EXPECT_EQ(counts.turned_share(), 0);
}

TEST(SurfaceAgreement, SquaresAreOfDistancesAlongNormals) {
  const KeptPlaceSurface near = surface_of(wall_at(1.99), Pose::Identity()),
                         far = surface_of(wall_at(2), Pose::Identity());
  const SurfaceAgreement counts = SurfaceAligner::agreement(far, near, Pose::Identity());
  EXPECT_EQ(counts.same, near.points_seen);
  EXPECT_NEAR(counts.squares_m2 / static_cast<double>(counts.same), 1e-4, 1e-6);
}

TEST(SurfaceAgreement, AWallThatHasComeNearerStandsInFreeSpace) {
  const KeptPlaceSurface far = surface_of(wall_at(2), Pose::Identity()),
                         near = surface_of(wall_at(1.7), Pose::Identity());
  const SurfaceAgreement there = SurfaceAligner::agreement(far, near, Pose::Identity());
  EXPECT_EQ(there.before, near.points_seen);
  EXPECT_EQ(there.same + there.turned, 0);
  EXPECT_EQ(there.conflict(), 1);
  EXPECT_EQ(there.overlap(), 0);
  // Behind what is seen there may be anything.
  const SurfaceAgreement back = SurfaceAligner::agreement(near, far, Pose::Identity());
  EXPECT_EQ(back.points, far.points_seen);
  EXPECT_EQ(back.before + back.same + back.turned, 0);
}

TEST(SurfaceAgreement, CountsTurnedNormals) {
  const KeptPlaceSurface wall = surface_of(wall_at(2), Pose::Identity());
  for (const double angle_deg : {29.0, 31.0}) {
    KeptPlaceSurface turned = wall;
    int64_t count = 0;
    for (size_t i = 0; i < turned.normals.size(); i += 3) {
      if (turned.normals[i].w <= 0) continue;
      const Eigen::Vector3d n = pose_of({angle_deg, 0, 0}, {0, 0, 0}).linear() * Eigen::Vector3d(0, 0, -1);
      turned.normals[i] = {static_cast<float>(n.x()), static_cast<float>(n.y()), static_cast<float>(n.z()),
                           1};
      ++count;
    }
    const SurfaceAgreement counts = SurfaceAligner::agreement(wall, turned, Pose::Identity());
    EXPECT_EQ(counts.turned, angle_deg > 30 ? count : 0);
    EXPECT_EQ(counts.same, wall.points_seen - counts.turned);
    EXPECT_EQ(counts.before, 0);
  }
}

TEST(SurfaceAgreement, OfViewsThatShareNothingIsNone) {
  const KeptPlaceSurface surface = surface_of(furnished_room(), Pose::Identity());
  for (const Pose& T : {pose_of({0, 0, 0}, {50, 0, 0}), pose_of({0, 180, 0}, {0, 0, 0})}) {
    const SurfaceAgreement counts = SurfaceAligner::agreement(surface, surface, T);
    EXPECT_EQ(counts.same + counts.turned + counts.before, 0);
    EXPECT_EQ(counts.overlap(), 0);
    EXPECT_EQ(counts.conflict(), 1);
    EXPECT_EQ(counts.turned_share(), 1);
  }
}

TEST(KeptPlaceSurface, HasThePointsOfItsDepth) {
  const KeptPlaceSurface wall = surface_of(wall_at(2), Pose::Identity());
  ASSERT_GT(wall.points_seen, 18'000);
  int64_t seen = 0;
  for (size_t i = 0; i < wall.points.size(); ++i) {
    if (wall.points[i].w <= 0) continue;
    ++seen;
    EXPECT_NEAR(wall.points[i].z, 2, 1e-6);
    EXPECT_NEAR(wall.normals[i].z, -1, 1e-5);
  }
  EXPECT_EQ(seen, wall.points_seen);
}

}  // namespace
}  // namespace kt::test
