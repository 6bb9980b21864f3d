// Tests of the pre-alignment of fast turns.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/tracking/rotation_aligner.h"

#include <algorithm>

#include "gtest/gtest.h"

#include "tests/support/analytic_scene.h"
#include "tests/support/devices.h"

namespace kt::test {
namespace {

struct Turn {
  AnalyticScene scene = furnished_room();
  RenderOptions render_options;
  Calibration calibration = small_calibration(2);
  Pose T_last_current = Pose::Identity();
  double exposure = 1;
  double colour_delay = 0;  // how long after the depth image the colour image is taken, in frame intervals
  exec::Device device = exec::Device::cpu(1);

  Pose aligned(const Pose& T_guess = Pose::Identity()) const {
    Preprocessor preprocessor(device, calibration, {});
    RotationAligner aligner(device, calibration);
    aligner.remember(preprocessor.process(render(scene, calibration, Pose::Identity(), render_options)));
    const Eigen::Vector3d turn = log_so3(T_last_current.linear());
    Pose T_last_shutter;
    T_last_shutter.linear() = exp_so3((1 + colour_delay) * turn);
    T_last_shutter.translation() = (1 + colour_delay) * T_last_current.translation();
    RenderOptions second = render_options;
    second.sequence = 1;
    RgbdFrame frame = render(scene, calibration, T_last_shutter, second);
    frame.colour_timestamp_us += std::lround(colour_delay * 1e6 / 30);
    for (Rgb8& c : frame.colour.pixels()) {
      const auto exposed = [this](uint8_t level) {
        return static_cast<uint8_t>(std::min(255.0, exposure * level));
      };
      c = {exposed(c.r), exposed(c.g), exposed(c.b)};
    }
    return aligner.align(preprocessor.process(frame), T_guess);
  }
  double error_deg(const Pose& T) const {
    return log_so3(T.linear().transpose() * T_last_current.linear()).norm() * 180 / 3.14159265358979;
  }
};

TEST(RotationAligner, FindsFastTurnsFromRest) {
  for (const Eigen::Vector3d& turn : {Eigen::Vector3d(0, 7.6, 0), {7.6, 0, 0}, {0, 0, 7.6}, {-4, 5, 3}}) {
    Turn trial;
    trial.T_last_current = pose_of(turn, {0.02, -0.01, 0.02});
    EXPECT_LT(trial.error_deg(trial.aligned()), 1.5) << turn.transpose();
    trial.exposure = 0.8;
    EXPECT_LT(trial.error_deg(trial.aligned()), 1.5) << "darker, " << turn.transpose();
  }
}

TEST(RotationAligner, KnowsWhenTheImagesWereTaken) {
  Turn trial;
  trial.T_last_current = pose_of({1, 4, 0}, {0, 0, 0});
  for (const double delay : {-0.4, 0.5}) {
    trial.colour_delay = delay;
    EXPECT_LT(trial.error_deg(trial.aligned()), 0.7) << delay;
  }
}

// Sideways past a wall, the image moves as it would in a turn of 1.1 degrees.
TEST(RotationAligner, KnowsHowFarTheCameraMoves) {
  const Eigen::Vector3d step(0.02, -0.01, 0.01);
  Turn trial;
  trial.scene = AnalyticScene({Plane{{0, 0, -1}, -1}});
  trial.render_options.blotches_m = 0.1;
  trial.T_last_current = pose_of({0.5, 1.5, -0.5}, step);
  EXPECT_LT(trial.error_deg(trial.aligned(pose_of({0, 0, 0}, step))), 0.1);
  EXPECT_GT(trial.error_deg(trial.aligned(pose_of({0, 0, 0}, {0, 0, 0}))), 0.8) << "the wall tells nothing";
  trial.colour_delay = -0.3;  // moves less between the images than between the depth images
  trial.calibration.T_colour_depth = pose_of({0, 0, 90}, {-0.03, 0, 0});
  EXPECT_LT(trial.error_deg(trial.aligned(pose_of({0, 0, 0}, step))), 0.15);
}

// A depth camera sees more than the colour camera does.
TEST(RotationAligner, OfANarrowColourCameraAsksForWhatThatCanShow) {
  Turn trial;
  trial.calibration.colour.fx = trial.calibration.colour.fy = 2.2 * trial.calibration.depth.fx;
  trial.T_last_current = pose_of({1, 3, -1}, {0, 0, 0});
  EXPECT_LT(trial.error_deg(trial.aligned()), 0.8);
}

TEST(RotationAligner, TurnsInTheFrameOfTheDepthCamera) {
  Turn trial;
  trial.calibration.T_colour_depth = pose_of({0, 0, 90}, {-0.02, 0, 0});
  trial.T_last_current = pose_of({5, 0, 0}, {0, 0, 0});
  EXPECT_LT(trial.error_deg(trial.aligned()), 1);
}

TEST(RotationAligner, KeepsTheGuessWhereItCannotTell) {
  const Calibration calibration = small_calibration();
  const exec::Device device = exec::Device::cpu(1);
  Preprocessor preprocessor(device, calibration, {});
  RotationAligner aligner(device, calibration);
  const Pose guess = pose_of({1, 2, 3}, {0.1, 0, 0});
  RgbdFrame frame = render(furnished_room(), calibration, Pose::Identity());
  EXPECT_EQ(aligner.align(preprocessor.process(frame), guess).matrix(), guess.matrix())
      << "nothing to compare with";
  aligner.remember(preprocessor.process(frame));
  frame.colour = {};
  EXPECT_EQ(aligner.align(preprocessor.process(frame), guess).matrix(), guess.matrix()) << "no colour";
}

TEST(RotationAligner, GivesTheSameBitsOnEveryDevice) {
  Turn trial;
  trial.T_last_current = pose_of({-4, 5, 3}, {0.02, -0.01, 0.02});
  const Pose reference = trial.aligned();
  for (const exec::Device& device : parity_devices()) {
    trial.device = device;
    EXPECT_EQ(trial.aligned().matrix(), reference.matrix()) << name_of(device);
  }
}

}  // namespace
}  // namespace kt::test
