// The prior against closed forms, its limits, and whether its information tells the truth about drift.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/tracking/motion_prior.h"

#include <cmath>
#include <gtest/gtest.h>
#include <numbers>

#include "shared/core/rng.h"
#include "tests/support/analytic_scene.h"
#include "tests/support/pose_matchers.h"

namespace kt::test {
namespace {

constexpr int64_t kStart_us = 1305031102160407;
constexpr double kRotationSigma = 0.01, kTranslationSigma = 0.02;
constexpr int64_t kPeriod_us = 20'000;  // 50 Hz

Vector6d twist_of(double wx, double wy, double wz, double vx, double vy, double vz) {
  Vector6d twist;
  twist << wx, wy, wz, vx, vy, vz;
  return twist;
}

const Vector6d kTwist = twist_of(0.1, 0.8, -0.2, 0.3, -0.1, 0.6);

int64_t after_us(double seconds) { return kStart_us + std::llround(seconds * 1e6); }

MotionSample pose_sample(int64_t timestamp_us, const Pose& T_prior) {
  MotionSample sample;
  sample.timestamp_us = timestamp_us;
  sample.T_prior = T_prior;
  sample.rotation_sigma = kRotationSigma;
  sample.translation_sigma = kTranslationSigma;
  return sample;
}

MotionSample velocity_sample(int64_t timestamp_us, const Vector6d& velocity) {
  MotionSample sample = pose_sample(timestamp_us, Pose::Identity());
  sample.kind = MotionSample::Kind::kVelocity;
  sample.velocity = velocity;
  return sample;
}

/// Moves with kTwist from some place in the frame of the stream, one sample per period for `seconds`.
MotionPrior steady_poses(double seconds) {
  MotionPrior prior;
  const Pose T_prior_start = exp_se3(twist_of(1, 2, -0.5, 10, -20, 3));
  for (int64_t t_us = 0; t_us <= std::llround(seconds * 1e6); t_us += kPeriod_us) {
    const Pose T_start_camera = exp_se3(kTwist * static_cast<double>(t_us) * 1e-6);
    EXPECT_TRUE(prior.add(pose_sample(kStart_us + t_us, T_prior_start * T_start_camera)));
  }
  return prior;
}

TEST(MotionPrior, AConstantTwistIsExactBetweenSamplesAndBehindThem) {
  const MotionPrior prior = steady_poses(2);
  for (const auto& [from_s, to_s] :
       {std::pair{0.0, 2.0}, {0.013, 0.0461}, {0.1, 0.105}, {1.9, 2.2}, {2.05, 2.1999}}) {
    const auto motion = prior.between(after_us(from_s), after_us(to_s));
    ASSERT_TRUE(motion) << from_s << " " << to_s;
    EXPECT_POSE_NEAR(motion->T_from_to, exp_se3(kTwist * (to_s - from_s)), 1e-6, 1e-9);
    EXPECT_TRUE(motion->has_rotation && motion->has_translation);
  }
}

TEST(MotionPrior, OneVelocityIsCarriedOn) {
  MotionPrior prior;
  EXPECT_TRUE(prior.add(velocity_sample(kStart_us, kTwist)));
  const auto motion = prior.between(after_us(0.05), after_us(0.2));
  ASSERT_TRUE(motion);
  EXPECT_POSE_NEAR(motion->T_from_to, exp_se3(kTwist * 0.15), 1e-6, 1e-9);
  EXPECT_FALSE(prior.between(after_us(0.05), after_us(0.2) + 1));
}

TEST(MotionPrior, VelocitiesHoldUntilTheNextSample) {
  MotionPrior prior;
  const Vector6d first = twist_of(0, 0.5, 0, 0, 0, 1), second = twist_of(0.2, 0, 0, 0.4, 0, 0);
  prior.add(velocity_sample(after_us(0), first));
  prior.add(velocity_sample(after_us(0.3), second));
  const auto motion = prior.between(after_us(0.1), after_us(0.35));
  ASSERT_TRUE(motion);
  EXPECT_POSE_NEAR(motion->T_from_to, exp_se3(first * 0.2) * exp_se3(second * 0.05), 1e-9, 1e-12);
}

TEST(MotionPrior, PosesAt50HzFollowAnUnsteadyPath) {
  // Turning to and fro by 30 degrees while going forward and up and down.
  const auto pose_at = [](double t) {
    return pose_of(
        twist_of(0.2 * std::sin(3 * t), 0.5 * std::sin(2 * t), 0.1 * std::cos(t), 0, 0, 0).head<3>() *
            (180 / std::numbers::pi),
        {0.5 * std::sin(t), 0.1 * std::cos(4 * t), 0.7 * t});
  };
  MotionPrior prior;
  for (int64_t t_us = 0; t_us <= 5'000'000; t_us += kPeriod_us)
    prior.add(pose_sample(kStart_us + t_us, pose_at(static_cast<double>(t_us) * 1e-6)));
  for (double t = 0.007; t < 4.9; t += 1.0 / 30) {
    const auto motion = prior.between(after_us(t), after_us(t + 1.0 / 30));
    ASSERT_TRUE(motion);
    // Between samples the path leaves the twist by acceleration * period^2 / 8: 2 m/s^2 are 0.1 mm.
    EXPECT_POSE_NEAR(motion->T_from_to, pose_at(t).inverse() * pose_at(t + 1.0 / 30), 0.02, 2e-4);
  }
}

TEST(MotionPrior, InformationOfATurnOnTheSpotIsThatOfTheGrowth) {
  MotionPrior prior;
  prior.add(velocity_sample(kStart_us, twist_of(0, 1, 0, 0, 0, 0)));
  const auto motion = prior.between(after_us(0.02), after_us(0.12));
  ASSERT_TRUE(motion);
  Vector6d expected;
  expected << Eigen::Vector3d::Constant(1 / (kRotationSigma * kRotationSigma * 0.1)),
      Eigen::Vector3d::Constant(1 / (kTranslationSigma * kTranslationSigma * 0.1));
  EXPECT_TRUE(motion->information.isApprox(Matrix6d(expected.asDiagonal()), 1e-9)) << motion->information;
}

TEST(MotionPrior, AHoleIsToldOnlyWhereItLies) {
  for (const int64_t hole_us : {500'000, 500'001}) {
    MotionPrior prior;
    for (const int64_t t_us : {int64_t{0}, int64_t{100'000}, 100'000 + hole_us, 200'000 + hole_us})
      prior.add(pose_sample(kStart_us + t_us, exp_se3(kTwist * static_cast<double>(t_us) * 1e-6)));
    const int64_t end_us = kStart_us + 100'000 + hole_us;
    const bool closed = hole_us <= 500'000;
    EXPECT_TRUE(prior.between(kStart_us, kStart_us + 100'000));
    EXPECT_TRUE(prior.between(end_us, end_us + 50'000));
    EXPECT_EQ(prior.between(kStart_us, kStart_us + 100'001).has_value(), closed);
    EXPECT_EQ(prior.between(kStart_us + 300'000, kStart_us + 400'000).has_value(), closed);
    EXPECT_EQ(prior.between(end_us - 1, end_us + 1).has_value(), closed);
  }
}

TEST(MotionPrior, AStreamThatIsSetToAnotherPlaceHasAHoleThere) {
  for (const bool jumps : {false, true}) {
    MotionPrior prior;
    for (int i = 0; i < 10; ++i)
      prior.add(pose_sample(after_us(0.1 * i), pose_of({0, 0, 0}, {i < 5 || !jumps ? 0.1 * i : 1e6, 0, 0})));
    EXPECT_TRUE(prior.between(after_us(0), after_us(0.4)));
    EXPECT_EQ(prior.between(after_us(0.3), after_us(0.6)).has_value(), !jumps);
    EXPECT_TRUE(prior.between(after_us(0.5), after_us(0.9)));
  }
}

TEST(MotionPrior, AVelocityThatCannotBeIsNotBelieved) {
  for (const double speed : {100.0, 101.0, 1e4}) {
    MotionPrior turning, going;
    turning.add(velocity_sample(kStart_us, twist_of(0, speed, 0, 0, 0, 0)));
    going.add(velocity_sample(kStart_us, twist_of(0, 0, 0, 0, -speed, 0)));
    EXPECT_EQ(turning.between(kStart_us, after_us(0.1)).has_value(), speed <= 100);
    EXPECT_EQ(going.between(kStart_us, after_us(0.1)).has_value(), speed <= 100);
  }
}

TEST(MotionPrior, InformationStaysOneThatAMessageHoldsOverTheLongestLevers) {
  for (const double speed : {0.0, 1.0, 100.0}) {
    for (const double rotation_sigma : {1e-300, 1e-2, 1e300}) {
      for (const double translation_sigma : {1e-300, 1e300}) {
        MotionPrior prior;
        for (int i = 0; i < 150; ++i) {
          MotionSample sample = velocity_sample(after_us(0.4 * i), twist_of(0.01, 0.02, 0.03, speed, 0, 0));
          sample.rotation_sigma = rotation_sigma;
          sample.translation_sigma = translation_sigma;
          prior.add(sample);
        }
        const auto motion = prior.between(kStart_us, after_us(59.5));
        ASSERT_TRUE(motion);
        EXPECT_TRUE(motion->information.allFinite() && motion->information.diagonal().minCoeff() >= 0)
            << speed << " " << rotation_sigma << " " << translation_sigma;
      }
    }
  }
}

TEST(MotionPrior, ReachesFromItsOldestSampleTo200MillisecondsBehindItsNewest) {
  const MotionPrior prior = steady_poses(1);
  EXPECT_FALSE(prior.between(kStart_us - 1, kStart_us + 100));
  EXPECT_TRUE(prior.between(kStart_us, kStart_us + 100));
  EXPECT_TRUE(prior.between(after_us(1.1), after_us(1.2)));
  EXPECT_FALSE(prior.between(after_us(1.1), after_us(1.2) + 1));
  EXPECT_FALSE(prior.between(after_us(0.5), after_us(0.5)));
  EXPECT_FALSE(prior.between(after_us(0.5), after_us(0.4)));
  EXPECT_FALSE(MotionPrior().between(0, 1));
}

TEST(MotionPrior, OnePoseOrOneBehindAHoleCannotBeCarriedOn) {
  MotionPrior prior;
  prior.add(pose_sample(after_us(0), Pose::Identity()));
  EXPECT_FALSE(prior.between(after_us(0), after_us(0.1)));
  prior.add(pose_sample(after_us(2), Pose::Identity()));
  EXPECT_FALSE(prior.between(after_us(2), after_us(2.1)));
  prior.add(pose_sample(after_us(2.1), Pose::Identity()));
  EXPECT_TRUE(prior.between(after_us(2), after_us(2.2)));
}

TEST(MotionPrior, AnInertialUnitTellsOfRotationOnly) {
  MotionPrior velocities, poses;
  for (int i = 0; i <= 20; ++i) {
    MotionSample sample = velocity_sample(after_us(0.01 * i), twist_of(0, 1, 0, 9, 9, 9));
    sample.translation_sigma = 0;
    EXPECT_TRUE(velocities.add(sample));
    sample.kind = MotionSample::Kind::kPose;
    sample.T_prior = pose_of({0, 0.01 * i * 180 / std::numbers::pi, 0}, {5.0 * i, 0, 0});
    EXPECT_TRUE(poses.add(sample));
  }
  for (const MotionPrior* prior : {&velocities, &poses}) {
    const auto motion = prior->between(after_us(0.003), after_us(0.153));
    ASSERT_TRUE(motion);
    EXPECT_TRUE(motion->has_rotation);
    EXPECT_FALSE(motion->has_translation);
    EXPECT_POSE_NEAR(motion->T_from_to, exp_se3(twist_of(0, 0.15, 0, 0, 0, 0)), 1e-6, 1e-12);
    Matrix6d expected = Matrix6d::Zero();
    expected.diagonal().head<3>().setConstant(1 / (kRotationSigma * kRotationSigma * 0.15));
    EXPECT_TRUE(motion->information.isApprox(expected, 1e-6)) << motion->information;
  }
}

TEST(MotionPrior, WheelsWithoutAGyroscopeTellOfTranslationOnly) {
  MotionPrior prior;
  MotionSample sample = velocity_sample(kStart_us, twist_of(3, 3, 3, 0, 0, 0.5));
  sample.rotation_sigma = 0;
  EXPECT_TRUE(prior.add(sample));
  const auto motion = prior.between(kStart_us, after_us(0.1));
  ASSERT_TRUE(motion);
  EXPECT_FALSE(motion->has_rotation);
  EXPECT_TRUE(motion->has_translation);
  EXPECT_POSE_NEAR(motion->T_from_to, pose_of({0, 0, 0}, {0, 0, 0.05}), 1e-12, 1e-12);
  Matrix6d expected = Matrix6d::Zero();
  expected.diagonal().tail<3>().setConstant(1 / (kTranslationSigma * kTranslationSigma * 0.1));
  EXPECT_TRUE(motion->information.isApprox(expected, 1e-9)) << motion->information;
}

TEST(MotionPrior, WhatIsNotMeasuredAllAlongIsNotKnown) {
  MotionPrior prior;
  MotionSample sample = velocity_sample(kStart_us, kTwist);
  prior.add(sample);
  sample.timestamp_us = after_us(0.1);
  sample.translation_sigma = 0;
  prior.add(sample);
  sample.timestamp_us = after_us(0.2);
  sample.translation_sigma = kTranslationSigma;
  sample.rotation_sigma = 0;
  prior.add(sample);
  EXPECT_TRUE(prior.between(kStart_us, after_us(0.1))->has_translation);
  EXPECT_FALSE(prior.between(kStart_us, after_us(0.15))->has_translation);
  EXPECT_TRUE(prior.between(kStart_us, after_us(0.15))->has_rotation);
  EXPECT_FALSE(prior.between(kStart_us, after_us(0.25)));
}

TEST(MotionPrior, RefusesWhatDoesNotFitTheStream) {
  MotionPrior prior;
  MotionSample nothing = velocity_sample(after_us(0), kTwist),
               only_translation = pose_sample(after_us(0), Pose::Identity());
  nothing.rotation_sigma = nothing.translation_sigma = only_translation.rotation_sigma = 0;
  EXPECT_FALSE(prior.add(nothing));
  EXPECT_FALSE(prior.add(only_translation));
  EXPECT_TRUE(prior.add(velocity_sample(after_us(1), kTwist)));
  EXPECT_FALSE(prior.add(velocity_sample(after_us(1), kTwist)));
  EXPECT_FALSE(prior.add(velocity_sample(after_us(0.5), kTwist)));
  EXPECT_FALSE(prior.add(pose_sample(after_us(2), Pose::Identity())));
  EXPECT_TRUE(prior.add(velocity_sample(after_us(1.1), kTwist)));
}

TEST(MotionPrior, ForgetsWhatIsOlderThanAMinute) {
  const MotionPrior prior = steady_poses(70);
  EXPECT_FALSE(prior.between(after_us(9.9), after_us(11)));
  EXPECT_TRUE(prior.between(after_us(10), after_us(11)));
}

// Mean of the normalised squared error over many streams that drift by a random walk; 6 where the information
// tells the truth.
double mean_squared_error(bool velocities, double span_s) {
  constexpr int kStreams = 400;
  const double period_s = static_cast<double>(kPeriod_us) * 1e-6;
  double sum = 0;
  for (uint64_t stream = 0; stream < kStreams; ++stream) {
    MotionPrior prior;
    Pose T_prior = exp_se3(twist_of(0.3, 0.2, 0.1, 4, 5, 6));
    for (int64_t k = 0; static_cast<double>(k) * period_s <= span_s + 0.1; ++k) {
      Vector6d error;  // of the stretch that begins here
      for (int axis = 0; axis < 6; ++axis) {
        error[axis] = (axis < 3 ? kRotationSigma : kTranslationSigma) * std::sqrt(period_s) *
                      random_normal(stream, static_cast<uint64_t>(axis), static_cast<uint64_t>(k));
      }
      const int64_t stamp_us = kStart_us + k * kPeriod_us;
      EXPECT_TRUE(prior.add(velocities ? velocity_sample(stamp_us, kTwist + error / period_s)
                                       : pose_sample(stamp_us, T_prior)));
      T_prior = T_prior * exp_se3(kTwist * period_s) * exp_se3(error);
    }
    const auto motion = prior.between(kStart_us, after_us(span_s));
    if (!motion) return -1;
    const Vector6d error = log_se3(motion->T_from_to * exp_se3(kTwist * span_s).inverse());
    sum += error.dot(motion->information * error);
  }
  return sum / kStreams;
}

TEST(MotionPrior, InformationTellsTheTruthAboutARandomWalk) {
  for (const bool velocities : {false, true}) {
    for (const double span_s : {0.02, 0.1, 1.0, 4.0}) {  // at 0.7 m/s, turning: the last has long levers
      const double error = mean_squared_error(velocities, span_s);
      EXPECT_GT(error, 6 / 1.5) << velocities << " " << span_s;
      EXPECT_LT(error, 6 * 1.5) << velocities << " " << span_s;
    }
  }
}

}  // namespace
}  // namespace kt::test
