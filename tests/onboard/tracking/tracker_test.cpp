// Tests of frame-to-model tracking in scenes with known motion.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/tracking/tracker.h"

#include <cmath>
#include <cstring>

#include "gtest/gtest.h"

#include "tests/onboard/tracking/tracker_trial.h"
#include "tests/support/devices.h"
#include "tests/support/pose_matchers.h"

namespace kt::test {
namespace {

std::vector<Pose> small_motions() {
  std::vector<Pose> motions;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {-1.0, 1.0}) {
      motions.push_back(pose_of({0, 0, 0}, 0.03 * sign * Eigen::Vector3d::Unit(axis)));
      motions.push_back(pose_of(2 * sign * Eigen::Vector3d::Unit(axis), {0, 0, 0}));
    }
  }
  motions.push_back(pose_of({1.5, -1, 2}, {0.02, 0.03, -0.04}));
  motions.push_back(pose_of({-2, 2.5, -1}, {-0.03, 0.01, 0.05}));
  return motions;
}

TEST(Tracker, RecoversSmallMotionsToAFractionOfAMillimetre) {
  for (const Pose& motion : small_motions()) {
    Trial trial;
    trial.scene = room_corner();
    trial.calibration = small_calibration(2);
    trial.T_odom_model = trial.T_odom_guess = pose_of({3, -5, 2}, {0.1, -0.1, 0.1});
    trial.T_odom_camera = trial.T_odom_model * motion;
    trial.half_model = motion.translation().z() != 0;  // a model view may be coarser than the frame
    const TrackResult result = trial.run();
    EXPECT_EQ(result.status, TrackingStatus::kGood);
    EXPECT_POSE_NEAR(result.T_odom_camera, trial.T_odom_camera, 0.02, 5e-4);
  }
}

// Edges and creases are as wide as a few of these coarse pixels.
TEST(Tracker, RecoversSmallMotionsAmongFurniture) {
  for (const Pose& motion : small_motions()) {
    Trial trial;
    trial.T_odom_model = trial.T_odom_guess = pose_of({3, -5, 2}, {0.2, -0.1, 0.3});
    trial.T_odom_camera = trial.T_odom_model * motion;
    const TrackResult result = trial.run();
    EXPECT_EQ(result.status, TrackingStatus::kGood);
    EXPECT_POSE_NEAR(result.T_odom_camera, trial.T_odom_camera, 0.1, 0.006);
  }
}

TEST(Tracker, DoesNotDependMuchOnTheGuess) {
  Trial trial;
  trial.T_odom_camera = pose_of({1, 2, -1}, {0.03, -0.02, 0.02});
  trial.T_odom_guess = trial.T_odom_camera;
  const Pose from_truth = trial.run().T_odom_camera;
  for (const Pose& off : small_motions()) {
    trial.T_odom_guess = trial.T_odom_camera * off;
    EXPECT_POSE_NEAR(trial.run().T_odom_camera, from_truth, 0.02, 5e-4);
  }
}

TEST(Tracker, ToleratesSensorNoise) {
  Trial trial;
  trial.scene = room_corner();
  trial.calibration = small_calibration(2);
  trial.T_odom_camera = pose_of({1, 2, -1}, {0.03, -0.02, 0.02});
  for (uint64_t seed = 0; seed < 3; ++seed) {
    trial.render_options = {.noise_sigmas = 1, .seed = seed};
    const TrackResult result = trial.run();
    EXPECT_EQ(result.status, TrackingStatus::kGood);
    EXPECT_POSE_NEAR(result.T_odom_camera, trial.T_odom_camera, 0.05, 0.002);
  }
}

TEST(Tracker, JudgesAGoodFitAsOne) {
  Trial trial;
  trial.T_odom_camera = pose_of({0, 1, 0}, {0.01, 0, 0});
  const TrackResult result = trial.run();
  EXPECT_GT(result.quality.inlier_share, 0.9);
  EXPECT_GT(result.quality.overlap, 0.9);
  EXPECT_LT(result.quality.residual_m, 0.003);
  EXPECT_GT(result.quality.conditioning, 0.01);
}

// A wall leaves sliding along it and turning about its normal free: there the guess must stay.
TEST(Tracker, KeepsTheGuessWhereAWallSaysNothing) {
  Trial trial;
  trial.scene = AnalyticScene({Plane{{0, 0, -1}, -1.5}});
  trial.T_odom_camera = pose_of({1, -1, 0}, {0, 0, 0.03});
  trial.T_odom_guess = pose_of({0, 0, 1.5}, {0.02, -0.03, 0});
  const TrackResult result = trial.run();
  const Pose& T = result.T_odom_camera;
  EXPECT_NEAR(T.translation().z(), 0.03, 5e-4) << "the wall measures its distance";
  const Eigen::Vector3d wall_camera = T.linear().transpose() * Eigen::Vector3d(0, 0, -1),
                        truth = trial.T_odom_camera.linear().transpose() * Eigen::Vector3d(0, 0, -1);
  EXPECT_LT((wall_camera - truth).norm(), 5e-4) << "and its two tilts";
  EXPECT_NEAR(T.translation().x(), 0.02, 2e-3);
  EXPECT_NEAR(T.translation().y(), -0.03, 2e-3);
  EXPECT_NEAR(log_so3(T.linear()).z() * 180 / M_PI, 1.5, 0.05);
  EXPECT_LT(result.quality.conditioning, 1e-3);
}

TEST(Tracker, KeepsTheGuessAlongABareCorridor) {
  Trial trial;
  trial.scene = AnalyticScene(
      {Plane{{1, 0, 0}, -0.8}, Plane{{-1, 0, 0}, -0.9}, Plane{{0, -1, 0}, -1.0}, Plane{{0, 1, 0}, -1.3}});
  trial.calibration = small_calibration(2);
  trial.T_odom_camera = pose_of({1, 1, 1}, {0.02, -0.01, 0});
  trial.T_odom_guess = pose_of({0, 0, 0}, {0, 0, 0.07});
  const TrackResult result = trial.run();
  EXPECT_GT(result.quality.free_directions, 0);
  EXPECT_LT(result.information(5, 5), 1e-3 * result.information(3, 3)) << "a guess is no measurement";
  EXPECT_NEAR(result.T_odom_camera.translation().z(), 0.07, 3e-3);
  Pose across = result.T_odom_camera;
  across.translation().z() = 0;
  // A turn with a step aside, which hardly changes what is seen of the walls, is left to the guess as well.
  EXPECT_POSE_NEAR(across, trial.T_odom_camera, 0.3, 0.015);
}

// What geometry leaves free, texture holds: along a wall, along a corridor, and for a colour camera that
// stands beside the depth camera.
TEST(Tracker, TextureHoldsWhatGeometryLeavesFree) {
  for (const bool registered : {true, false}) {
    Trial wall;
    wall.calibration = small_calibration(2);
    if (!registered) {
      wall.calibration.colour.fx = wall.calibration.colour.fy = 230;
      wall.calibration.T_colour_depth = pose_of({0.3, -0.2, 1}, {-0.03, 0.01, 0});
    }
    wall.has_reference = true;
    wall.scene = AnalyticScene({Plane{{0, 0, -1}, -1.5}});
    wall.render_options.texture_scale = 6;
    wall.T_odom_camera = pose_of({1, -1, 1}, {0.02, -0.03, 0.03});
    EXPECT_POSE_NEAR(wall.run().T_odom_camera, wall.T_odom_camera, 0.1, 2e-3);
    EXPECT_EQ(wall.run().quality.free_directions, 0);
    Trial blind = wall;
    blind.has_reference = false;
    EXPECT_EQ(blind.run().quality.free_directions, 3) << "sliding two ways, and turning";

    Trial corridor = wall;
    corridor.scene = AnalyticScene(
        {Plane{{1, 0, 0}, -0.8}, Plane{{-1, 0, 0}, -0.9}, Plane{{0, -1, 0}, -1.0}, Plane{{0, 1, 0}, -1.3}});
    corridor.T_odom_camera = pose_of({1, 1, 1}, {0.02, -0.01, 0.05});
    EXPECT_POSE_NEAR(corridor.run().T_odom_camera, corridor.T_odom_camera, 0.1, 3e-3);
  }
}

TEST(Tracker, ExposureMayChange) {
  Trial trial;
  trial.calibration = small_calibration(2);
  trial.has_reference = true;
  trial.scene = AnalyticScene({Plane{{0, 0, -1}, -1.5}});
  trial.render_options.texture_scale = 6;
  trial.T_odom_camera = pose_of({1, -1, 1}, {0.02, -0.03, 0.03});
  RgbdFrame frame = render(trial.scene, trial.calibration, trial.T_odom_camera, trial.render_options);
  for (Rgb8& c : frame.colour.pixels()) {
    const auto exposed = [](uint8_t level) { return static_cast<uint8_t>(0.75 * level + 12.5); };
    c = {exposed(c.r), exposed(c.g), exposed(c.b)};
  }
  const TrackResult result = trial.run(frame);
  EXPECT_POSE_NEAR(result.T_odom_camera, trial.T_odom_camera, 0.1, 2e-3);
  EXPECT_NEAR(result.exposure.gain, -0.25, 0.02);
  EXPECT_NEAR(result.exposure.bias, 12, 2);
}

TEST(Tracker, InformationIsLeastWhereGeometryIsWeak) {
  Trial trial;
  trial.scene = AnalyticScene({Plane{{0, 0, -1}, -1.5}});
  const Matrix6d information = trial.run().information;
  EXPECT_LT((information - information.transpose()).cwiseAbs().maxCoeff(),
            1e-9 * information.cwiseAbs().maxCoeff());
  EXPECT_GT(information(5, 5), 1e4) << "1 cm at worst towards the wall";
  EXPECT_LT(information(3, 3), 1e-3 * information(5, 5)) << "nothing along it";
  EXPECT_LT(information(4, 4), 1e-3 * information(5, 5));
}

// Normalised estimation error squared: 6 on average for a consistent covariance, less for a cautious one.
TEST(Tracker, InformationIsNotOverconfident) {
  Trial trial;
  constexpr uint64_t kTrials = 20;
  double sum = 0;
  for (uint64_t seed = 0; seed < kTrials; ++seed) {
    trial.render_options = {.noise_sigmas = 1, .seed = 100 + seed};
    const TrackResult result = trial.run();
    const Vector6d error = log_se3(result.T_odom_camera * trial.T_odom_camera.inverse());
    sum += error.dot(result.information * error);
  }
  EXPECT_LT(sum / kTrials, 12);
}

// A camera that turns by 150 degrees per second while its colour image is taken 12 ms after the depth image.
TEST(Tracker, KnowsWhenTheColourImageWasTaken) {
  for (const int axis : {0, 1, 2}) {
    Trial trial;
    trial.scene = AnalyticScene({Plane{{0, 0, -1}, -1.5}});
    trial.calibration = small_calibration(2);
    trial.calibration.T_colour_depth = pose_of({0.3, -0.2, 1}, {-0.03, 0.01, 0});
    trial.has_reference = true;
    trial.render_options.texture_scale = 6;
    trial.T_odom_camera = pose_of({1, -1, 1}, {0.02, -0.03, 0.03});
    constexpr double kDelay_s = 0.012;
    Vector6d velocity = Vector6d::Zero();
    velocity(axis) = 150 * M_PI / 180;
    velocity.tail<3>() = Eigen::Vector3d(0.1, -0.2, 0.1);
    const Pose T_odom_shutter = trial.T_odom_camera * exp_se3(kDelay_s * velocity);
    RgbdFrame frame = render(trial.scene, trial.calibration, trial.T_odom_camera, trial.render_options);
    frame.colour = render(trial.scene, trial.calibration, T_odom_shutter, trial.render_options).colour;
    frame.colour_timestamp_us = frame.timestamp_us + std::lround(kDelay_s * 1e6);

    trial.velocity = velocity;
    const Pose informed = trial.run(frame).T_odom_camera;
    EXPECT_POSE_NEAR(informed, trial.T_odom_camera, 0.15, 3e-3);
    trial.velocity.setZero();
    const Pose uninformed = trial.run(frame).T_odom_camera;
    if (axis == 2) {
      EXPECT_GT(rotation_error_deg(uninformed, trial.T_odom_camera), 1);
    } else {
      EXPECT_GT(translation_error_m(uninformed, trial.T_odom_camera), 0.02);
    }
  }
}

// A bare wall, seen from away from the odom frame's origin; what another sensor says is known in the camera's
// own frame.
Trial bare_wall() {
  Trial trial;
  trial.T_odom_model = pose_of({10, -20, 30}, {2, -1, 3});
  const Eigen::Vector3d n = trial.T_odom_model.linear() * Eigen::Vector3d(0, 0, -1);
  trial.scene = AnalyticScene({Plane{n, n.dot(trial.T_odom_model.translation()) - 1.5}});
  trial.T_odom_camera = trial.T_odom_model * pose_of({1, -1, 1.5}, {0.02, -0.03, 0.03});
  trial.T_odom_guess = trial.T_odom_model;
  trial.T_odom_motion = trial.T_odom_camera;
  return trial;
}

Matrix6d information_in_odom(const Trial& trial, double rotation_sigma, double translation_sigma_m) {
  Vector6d diagonal;
  diagonal << Eigen::Vector3d::Constant(rotation_sigma > 0 ? 1 / (rotation_sigma * rotation_sigma) : 0),
      Eigen::Vector3d::Constant(1 / (translation_sigma_m * translation_sigma_m));
  return transported(diagonal.asDiagonal(), trial.T_odom_model.inverse());
}

TEST(Tracker, ASensorsMotionHoldsWhatGeometryLeavesFree) {
  Trial trial = bare_wall();
  EXPECT_EQ(trial.run().quality.free_directions, 3);
  for (const double sigma_m : {0.002, 0.008}) {
    // So many pixels that 8 mm would not hold a direction if it were geometry that told it.
    if (sigma_m > 0.005) trial.calibration = small_calibration(4);
    trial.motion_information = information_in_odom(trial, sigma_m / 2, sigma_m);
    const TrackResult result = trial.run();
    EXPECT_EQ(result.quality.free_directions, 0);
    EXPECT_EQ(result.status, TrackingStatus::kGood);
    EXPECT_POSE_NEAR(result.T_odom_camera, trial.T_odom_camera, 0.05, 1e-3);
    EXPECT_LT(result.information.diagonal().tail<3>().minCoeff(), 1e-3 / (sigma_m * sigma_m))
        << "what the frame itself measures";
  }
  trial.motion_information = information_in_odom(trial, 0.02, 0.04);
  EXPECT_EQ(trial.run().quality.free_directions, 3) << "too vague to hold anything";
}

TEST(Tracker, AVagueMotionHardlyMovesAPoseThatGeometryTells) {
  Trial trial;
  trial.scene = room_corner();
  trial.calibration = small_calibration(2);
  trial.T_odom_model = trial.T_odom_guess = pose_of({3, -5, 2}, {0.1, -0.1, 0.1});
  trial.T_odom_camera = trial.T_odom_model * pose_of({1.5, -1, 2}, {0.02, 0.03, -0.04});
  const Pose alone = trial.run().T_odom_camera;
  trial.T_odom_motion = trial.T_odom_camera * pose_of({1, -1, 0.5}, {0.04, -0.03, 0.03});
  trial.motion_information = information_in_odom(trial, 0.05, 0.05);
  EXPECT_POSE_NEAR(trial.run().T_odom_camera, alone, 0.05, 1e-3);
}

TEST(Tracker, AMotionWithoutRotationLeavesRotationAlone) {
  Trial trial = bare_wall();
  trial.T_odom_guess = trial.T_odom_camera * pose_of({0, 0, 1}, {0, 0, 0});
  trial.T_odom_motion.linear() = trial.T_odom_model.linear();  // not measured
  trial.motion_information = information_in_odom(trial, 0, 0.002);
  const TrackResult result = trial.run();
  EXPECT_EQ(result.quality.free_directions, 1) << "the turn about the wall's normal";
  EXPECT_LT(translation_error_m(result.T_odom_camera, trial.T_odom_camera), 3e-3);
  const Eigen::Vector3d turned =
      log_so3(trial.T_odom_guess.linear().transpose() * result.T_odom_camera.linear());
  EXPECT_NEAR(turned.z() * 180 / M_PI, 0, 0.05);
}

TEST(Tracker, GivesTheSameBitsOnEveryDevice) {
  Trial trial;
  trial.T_odom_camera = pose_of({1.5, -1, 2}, {0.02, 0.03, -0.04});
  trial.render_options = {.noise_sigmas = 1, .seed = 3};
  trial.device = exec::Device::cpu(1);
  const TrackResult reference = trial.run();
  for (const exec::Device& device : parity_devices()) {
    trial.device = device;
    const TrackResult result = trial.run();
    EXPECT_EQ(result.T_odom_camera.matrix(), reference.T_odom_camera.matrix()) << name_of(device);
    EXPECT_EQ(result.information, reference.information) << name_of(device);
    EXPECT_EQ(result.quality.overlap, reference.quality.overlap);
    EXPECT_EQ(result.quality.inlier_share, reference.quality.inlier_share);
    EXPECT_EQ(result.quality.residual_m, reference.quality.residual_m);
  }
}

}  // namespace
}  // namespace kt::test
