// ATE and RPE against closed forms, a slow oracle and the benchmark's own results.
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/eval/trajectory_error.h"

#include <cmath>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <numbers>

#include "shared/core/rng.h"
#include "shared/io/file.h"
#include "shared/io/trajectory_file.h"
#include "tests/support/test_files.h"
#include "tools/eval/groundtruth.h"
#include "tools/eval/report.h"

namespace kt {
namespace {

using ::testing::HasSubstr;

/// A curl through space at 30 Hz.
Trajectory curl(int count) {
  Trajectory trajectory;
  for (int i = 0; i < count; ++i) {
    const double a = 0.02 * i;
    Vector6d xi;
    xi << 0.3 * std::sin(a), 0.5 * a, 0.1 * std::cos(2 * a), std::cos(a), 0.2 * a, std::sin(1.3 * a);
    trajectory.push_back(
        {.sequence = i, .timestamp_us = 1'000'000 + i * 33'333, .T_odom_camera = exp_se3(xi)});
  }
  return trajectory;
}

Trajectory moved(Trajectory trajectory, const Pose& T) {
  for (StampedPose& pose : trajectory) pose.T_odom_camera = T * pose.T_odom_camera;
  return trajectory;
}

const Pose kElsewhere = exp_se3((Vector6d() << 1, -2, 0.5, 10, 20, -30).finished());

TEST(AbsoluteTrajectoryError, AMovedTrajectoryHasNone) {
  const Trajectory truth = curl(200);
  const auto ate = absolute_trajectory_error(truth, moved(truth, kElsewhere));
  EXPECT_LT(ate.translation_m.max, 1e-12);
  EXPECT_TRUE(ate.T_groundtruth_estimate.isApprox(kElsewhere.inverse(), 1e-12));
  EXPECT_EQ(ate.samples.size(), 200u);
  EXPECT_EQ(ate.estimate_paired_share, 1);
  EXPECT_EQ(ate.groundtruth_covered_share, 1);
}

TEST(AbsoluteTrajectoryError, ErrorsAcrossAStraightLineStay) {
  // Along a line with offsets +-e across it, alternating, alignment can remove nothing.
  Trajectory truth, estimate;
  const double e = 0.03;
  for (int i = 0; i < 400; ++i) {
    StampedPose pose{.sequence = i, .timestamp_us = i * 33'333};
    pose.T_odom_camera.translation() = Eigen::Vector3d(0.1 * i, 0, 0);
    truth.push_back(pose);
    pose.T_odom_camera.translation().y() = (i % 4 == 0 || i % 4 == 3) ? e : -e;
    estimate.push_back(pose);
  }
  const auto ate = absolute_trajectory_error(truth, estimate);
  EXPECT_NEAR(ate.translation_m.rmse, e, 1e-6);
  EXPECT_NEAR(ate.translation_m.mean, e, 1e-6);
  EXPECT_NEAR(ate.translation_m.median, e, 1e-6);
  EXPECT_NEAR(ate.translation_m.standard_deviation, 0, 1e-5);
}

TEST(AbsoluteTrajectoryError, DoesNotForgiveAMirroredOrScaledWorld) {
  const Trajectory truth = curl(200);
  Trajectory mirrored = truth, scaled = truth;
  for (StampedPose& pose : mirrored) pose.T_odom_camera.translation().y() *= -1;
  for (StampedPose& pose : scaled) pose.T_odom_camera.translation() *= 1.1;
  EXPECT_GT(absolute_trajectory_error(truth, mirrored).translation_m.rmse, 0.05);
  EXPECT_GT(absolute_trajectory_error(truth, scaled).translation_m.rmse, 0.02);
}

TEST(AbsoluteTrajectoryError, CoverageCountsWhatIsMissing) {
  const Trajectory truth = curl(200);
  const Trajectory half(truth.begin(), truth.begin() + 100);
  const auto ate = absolute_trajectory_error(truth, half);
  EXPECT_EQ(ate.estimate_paired_share, 1);
  EXPECT_EQ(ate.groundtruth_covered_share, 0.5);
  EXPECT_EQ(absolute_trajectory_error(half, truth).estimate_paired_share, 0.5);
}

TEST(AbsoluteTrajectoryError, DifferentClocksAreNamed) {
  Trajectory late = curl(50);
  for (StampedPose& pose : late) pose.timestamp_us += 3'600'000'000;
  EXPECT_THAT(error_of([&] { absolute_trajectory_error(curl(50), late); }), HasSubstr("share a clock"));
  EXPECT_THROW(absolute_trajectory_error({}, {}), Error);
}

TEST(RelativePoseError, AConstantDriftShowsPerSpan) {
  // The estimate turns 0.001 rad about its own y axis too much at every frame.
  const Trajectory truth = curl(300);
  Trajectory estimate = truth;
  const double drift_rad = 0.001;
  Pose extra = Pose::Identity();
  extra.linear() = exp_so3({0, drift_rad, 0});
  for (size_t i = 1; i < truth.size(); ++i) {
    estimate[i].T_odom_camera = estimate[i - 1].T_odom_camera *
                                (truth[i - 1].T_odom_camera.inverse() * truth[i].T_odom_camera) * extra;
  }
  const auto rpe = relative_pose_error(truth, estimate, 1, DeltaUnit::kFrames);
  ASSERT_TRUE(rpe.has_value());
  EXPECT_EQ(rpe->pairs, 298);  // all but the last two: a span that ends at the last pose may be cut short
  EXPECT_NEAR(rpe->rotation_deg.mean, drift_rad * 180 / std::numbers::pi, 1e-9);
  EXPECT_NEAR(rpe->rotation_deg.max, drift_rad * 180 / std::numbers::pi, 1e-6);
  EXPECT_LT(rpe->translation_m.max, 1e-9 + 2 * drift_rad);
  // A span begins one frame before its extra turn: the axis has turned by that frame's motion.
  EXPECT_NEAR(rpe->mean_rotation_rad.y(), drift_rad, 0.02 * drift_rad);
  EXPECT_LT(Eigen::Vector2d(rpe->mean_rotation_rad.x(), rpe->mean_rotation_rad.z()).norm(), 0.2 * drift_rad);
  EXPECT_LT(relative_pose_error(truth, moved(truth, kElsewhere)).value().translation_m.max, 1e-11);
}

/// The definition with linear searches, seconds in double.
std::vector<double> slow_relative_errors(const Trajectory& truth, const Trajectory& estimate, double delta_s,
                                         double gap_s) {
  const auto nearest = [](const Trajectory& trajectory, double seconds) {
    size_t best = 0;
    for (size_t i = 0; i < trajectory.size(); ++i) {
      if (std::abs(trajectory[i].timestamp_us * 1e-6 - seconds) <
          std::abs(trajectory[best].timestamp_us * 1e-6 - seconds))
        best = i;
    }
    return best;
  };
  std::vector<double> errors_m;
  for (const StampedPose& pose : estimate) {
    const size_t j = nearest(estimate, pose.timestamp_us * 1e-6 + delta_s);
    if (j == estimate.size() - 1) continue;
    const StampedPose& truth_i = truth[nearest(truth, pose.timestamp_us * 1e-6)];
    const StampedPose& truth_j = truth[nearest(truth, estimate[j].timestamp_us * 1e-6)];
    if (std::abs(truth_i.timestamp_us - pose.timestamp_us) * 1e-6 > gap_s) continue;
    if (std::abs(truth_j.timestamp_us - estimate[j].timestamp_us) * 1e-6 > gap_s) continue;
    const Pose motion = pose.T_odom_camera.inverse() * estimate[j].T_odom_camera;
    const Pose true_motion = truth_i.T_odom_camera.inverse() * truth_j.T_odom_camera;
    errors_m.push_back((motion * true_motion.inverse()).translation().norm());
  }
  return errors_m;
}

TEST(RelativePoseError, AgreesWithASlowOracle) {
  Trajectory truth = curl(400), estimate;
  for (size_t i = 0; i < truth.size(); i += 1 + random_bits(5, 0, i) % 2) {
    StampedPose pose = truth[i];
    pose.timestamp_us += static_cast<int64_t>(random_bits(5, 1, i) % 9'000);
    for (int k = 0; k < 3; ++k)
      pose.T_odom_camera.translation()[k] += 0.01 * random_normal(5, 2 + static_cast<uint64_t>(k), i);
    estimate.push_back(pose);
  }
  truth.erase(truth.begin() + 150, truth.begin() + 170);  // a hole that no pair may bridge
  const std::vector<double> expected_m = slow_relative_errors(truth, estimate, 1, 2 * 0.033333);
  const auto rpe = relative_pose_error(truth, estimate);
  ASSERT_TRUE(rpe.has_value());
  EXPECT_EQ(rpe->pairs, static_cast<int64_t>(expected_m.size()));
  const Statistics expected = summarise(expected_m);
  EXPECT_GT(expected.rmse, 0.005);
  EXPECT_NEAR(rpe->translation_m.rmse, expected.rmse, 1e-12);
  EXPECT_NEAR(rpe->translation_m.max, expected.max, 1e-12);
}

TEST(RelativePoseError, SpansMayBeMetresOfPath) {
  const Trajectory truth = curl(400);
  EXPECT_LT(relative_pose_error(truth, truth, 0.5, DeltaUnit::kMetres).value().translation_m.max, 1e-12);
  EXPECT_GT(relative_pose_error(truth, truth, 0.5, DeltaUnit::kMetres).value().pairs, 100);
}

TEST(RelativePoseError, IsNoneWhereTheEstimateIsShorterThanTheSpan) {
  const Trajectory truth = curl(20);
  EXPECT_FALSE(relative_pose_error(truth, truth, 1, DeltaUnit::kSeconds).has_value());
  EXPECT_FALSE(relative_pose_error(truth, truth, 1000, DeltaUnit::kMetres).has_value());
  EXPECT_FALSE(relative_pose_error({}, {}).has_value());

  const auto ate = absolute_trajectory_error(truth, truth);
  EXPECT_TRUE(trajectory_json(ate, std::nullopt)["rpe"].is_null());
  EXPECT_TRUE(trajectory_json(ate, std::nullopt)["ate"]["rmse_m"].is_number());
  EXPECT_THAT(trajectory_text(ate, std::nullopt), HasSubstr("RPE                    –"));
}

/// A camera that turns on the spot, and one that flies straight on without turning.
std::vector<Trajectory> paths_of_no_extent() {
  Trajectory turning, straight;
  for (int i = 0; i < 60; ++i) {
    StampedPose pose{.sequence = i, .timestamp_us = i * 33'333};
    pose.T_odom_camera.linear() = exp_so3({0, 0.01 * i, 0});
    turning.push_back(pose);
    pose.T_odom_camera = Pose::Identity();
    pose.T_odom_camera.translation().z() = 0.01 * i;
    straight.push_back(pose);
  }
  return {turning, straight};
}

TEST(AlignPoses, TurningAndStraightPathsFixTheOrientationToo) {
  for (const Trajectory& truth : paths_of_no_extent()) {
    Trajectory estimate = moved(truth, kElsewhere);
    for (size_t i = 0; i < estimate.size(); ++i) {  // a tenth of a millimetre of noise
      for (int k = 0; k < 3; ++k)
        estimate[i].T_odom_camera.translation()[k] += 1e-4 * random_normal(3, static_cast<uint64_t>(k), i);
    }
    const Pose error = align_poses(truth, estimate) * kElsewhere;
    EXPECT_LT(rotation_angle(error), 1e-4);
    EXPECT_LT(error.translation().norm(), 1e-4);
  }
}

TEST(AlignPoses, IsExactForAMovedTrajectoryAndNeedsOnePose) {
  const Trajectory truth = curl(50);
  EXPECT_TRUE(align_poses(truth, moved(truth, kElsewhere)).isApprox(kElsewhere.inverse(), 1e-12));
  const Trajectory one(truth.begin() + 7, truth.begin() + 8);
  EXPECT_TRUE(align_poses(truth, moved(one, kElsewhere)).isApprox(kElsewhere.inverse(), 1e-9));
  EXPECT_THAT(error_of([&] { align_poses(truth, {}); }), HasSubstr("share a clock"));
}

TEST(AbsoluteTrajectoryError, GivesTheBenchmarksPublishedResults) {
  KT_NEEDS_RECORDING("trajectories");
  struct Expected {
    const char* name;
    double rmse_m;
    size_t pairs;
  };
  for (const auto& [name, rmse_m, pairs] :
       {Expected{"freiburg1_desk", 0.025831, 574}, Expected{"freiburg1_room", 0.101165, 1332},
        Expected{"freiburg1_xyz", 0.013473, 786}, Expected{"freiburg2_xyz", 0.026112, 3575}}) {
    const std::string path = (recordings() / "trajectories" / name).string();
    const auto ate = absolute_trajectory_error(read_groundtruth(path + "-groundtruth.txt"),
                                               read_trajectory(path + "-rgbdslam.txt"));
    EXPECT_NEAR(ate.translation_m.rmse, rmse_m, 1e-6) << name;
    EXPECT_EQ(ate.samples.size(), pairs) << name;
  }
}

TEST(Groundtruth, IclFilesAreBroughtToTheConventionOfTheirImages) {
  const ScratchDir folder;
  const std::string file = (folder.path() / "livingRoom0.gt.freiburg").string();
  write_file(file, "3 0 -2 1 0 0 0 1\n6 0 -2 2 0 0 0 1\n");
  const Trajectory poses = read_groundtruth(file);
  EXPECT_EQ(poses[0].timestamp_us, 100'000);
  EXPECT_EQ(poses[0].T_odom_camera.translation().y(), 2);
  write_file(file, "# nothing\n");
  EXPECT_THAT(error_of([&] { read_groundtruth(file); }), HasSubstr("holds no poses"));
}

TEST(Statistics, FollowTheirDefinitions) {
  const Statistics s = summarise({4, 1, 3, 2});
  EXPECT_EQ(s.mean, 2.5);
  EXPECT_EQ(s.median, 2.5);
  EXPECT_DOUBLE_EQ(s.rmse, std::sqrt(7.5));
  EXPECT_DOUBLE_EQ(s.standard_deviation, std::sqrt(1.25));
  EXPECT_EQ(s.min, 1);
  EXPECT_EQ(s.max, 4);
  EXPECT_NEAR(s.p95, 3.85, 1e-12);
  EXPECT_EQ(quantile({7}, 0.95), 7);
}

}  // namespace
}  // namespace kt
