// Views of a synthetic room, whose pose is known, compared.
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/match/pair_comparison.h"

#include <gtest/gtest.h>
#include <numbers>

#include "tools/match/orbit.h"

namespace kt {
namespace {

constexpr double kAhead_m = 2;

TEST(Orbit, LooksAtItsCentreFromTheSameDistance) {
  const SyntheticMission mission("room", {.frames = 1});
  const Pose T = mission.groundtruth()[0].T_odom_camera;
  const Pose T_turned = orbited(T, kAhead_m, 0.5);
  const Eigen::Vector3d centre(0, 0, kAhead_m);
  EXPECT_LT((T_turned * centre - T * centre).norm(), 1e-9);
  EXPECT_NEAR(rotation_angle(T.inverse() * T_turned), 0.5, 1e-9);
  EXPECT_TRUE(orbited(T, kAhead_m, 0).isApprox(T));
}

TEST(PairComparison, MeasuresAViewpointAndFitsTheTruthAsWellAsItself) {
  const SyntheticMission mission("room", {.frames = 1});
  Preprocessor preprocessor(exec::Device::cpu(1), mission.calibration(), {});
  KeyframeMaker maker(mission.calibration(), PlaceFeature::kSurf);
  PairComparer comparer(mission.calibration(), maker.kind().type);
  const Pose T = mission.groundtruth()[0].T_odom_camera;
  const Pose T_turned = orbited(T, kAhead_m, 10 * std::numbers::pi / 180);
  const auto place = [&](const Pose& at, int64_t number) {
    StampedPose pose;
    pose.sequence = number;
    return comparer.known(
        maker.make(KeyframeMaker::images_of(preprocessor.process(render_at(mission, at, number)), {}, pose)));
  };
  const KnownPlace from = place(T, 0), to = place(T_turned, 1);
  const PairComparison pair = comparer.compare(from, to, T.inverse() * T_turned);
  EXPECT_TRUE(pair.loop.accepted()) << to_string(pair.loop.verdict);
  ASSERT_TRUE(pair.truth && pair.fit && pair.truth->fit);
  EXPECT_NEAR(pair.truth->viewpoint_deg, 10, 3);
  EXPECT_GT(pair.truth->overlap, 0.7);
  EXPECT_LT(pair.truth->error_m, 0.005);
  EXPECT_NEAR(static_cast<double>(pair.fit->points), static_cast<double>(pair.truth->fit->points),
              0.01 * static_cast<double>(pair.fit->points));
  EXPECT_LT(pair.fit->reprojection_px, 1.2 * pair.truth->fit->reprojection_px);

  // A pose that is off fits worse in every way.
  Pose T_off = T.inverse() * T_turned;
  T_off.translation().x() += 0.1;
  const PairComparison off = comparer.compare(from, to, T_off);
  EXPECT_LT(off.truth->fit->points, pair.fit->points);
  EXPECT_GT(off.truth->fit->reprojection_px, 3 * pair.fit->reprojection_px);
  EXPECT_LT(off.truth->fit->matches, pair.fit->matches);
}

}  // namespace
}  // namespace kt
