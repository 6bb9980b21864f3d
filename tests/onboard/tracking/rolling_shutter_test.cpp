// Tests that a rolling shutter does not bend what is tracked: frames whose rows are rendered one after the
// other.
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>

#include "onboard/tracking/feature_detector.h"
#include "onboard/tracking/odometry.h"
#include "tests/onboard/tracking/model_views.h"
#include "tests/support/pose_matchers.h"

namespace kt::test {
namespace {

constexpr double kReadout_s = 0.03, kInterval_s = 33'333e-6;

Calibration rolling_camera(int scale = 2) {
  Calibration calibration = small_calibration(scale);
  calibration.T_colour_depth = pose_of({0.3, -0.2, 1}, {-0.03, 0.01, 0});
  calibration.readout_s = kReadout_s;
  return calibration;
}

Vector6d twist(double a, double b, double c, double x, double y, double z) {
  Vector6d result;
  result << a, b, c, x, y, z;
  return result;
}

// Largest error of a camera that moves on with one velocity, by the poses of an odometry that takes the
// shutter of its camera to need `readout_s`.
double worst_error_m(const Vector6d& velocity, double readout_s) {
  const exec::Device device = exec::Device::cpu(1);
  const AnalyticScene scene = room_corner();
  Calibration known = rolling_camera();
  known.readout_s = readout_s;
  Preprocessor preprocessor(device, known, {});
  Odometry odometry(device, known, {});
  ModelView view;
  const auto predict = [&](const Pose& T_odom_camera) -> const ModelView& {
    view = exact_model_view(device, scene, known.depth.pinhole().half(), T_odom_camera);
    return view;
  };
  double worst = 0;
  for (int64_t i = 0; i < 12; ++i) {
    const Pose truth = exp_se3(static_cast<double>(i) * kInterval_s * velocity);
    RenderOptions options{.texture_scale = 3, .sequence = i};
    if (i > 0) options.velocity = velocity;  // the first frame is not bent: it is the odom frame
    const FrameMaps& maps = preprocessor.process(render(scene, rolling_camera(), truth, options));
    const StampedPose pose = odometry.track(maps, i == 0 ? nullptr : &view, predict, {}, i);
    EXPECT_EQ(pose.status, TrackingStatus::kGood) << i;
    if (i >= 6) worst = std::max(worst, translation_error_m(pose.T_odom_camera, truth));
    odometry.remember(maps, predict(pose.T_odom_camera));
  }
  return worst;
}

TEST(RollingShutter, IsTakenOutOfThePoses) {
  for (const Vector6d& velocity :
       {twist(0, 0, 0, 0, 0.5, 0), twist(0, 0, 0, 0, 0, 0.5), twist(0, 0, 0, 0.2, -0.4, 0.4)}) {
    const double aware = worst_error_m(velocity, kReadout_s), unaware = worst_error_m(velocity, 0);
    EXPECT_LT(aware, 0.002) << velocity.transpose();
    EXPECT_GT(unaware, 3 * aware) << velocity.transpose();
  }
}

TEST(RollingShutter, IsTakenOutOfFeatures) {
  const exec::Device device = exec::Device::cpu(1);
  const Calibration calibration = rolling_camera(4);
  const AnalyticScene scene = room_corner();
  Preprocessor preprocessor(device, calibration, {});
  FeatureDetector detector(device, calibration);
  RenderOptions options{.blotches_m = 0.1};
  options.velocity = twist(0.4, -0.3, 0.2, 0.6, 1.0, -1.2);
  RgbdFrame frame = render(scene, calibration, Pose::Identity(), options);
  constexpr double kDelay_s = 0.01;
  frame.colour = render(scene, calibration, exp_se3(kDelay_s * options.velocity), options).colour;
  frame.colour_timestamp_us += std::lround(kDelay_s * 1e6);
  const FrameMaps& maps = preprocessor.process(frame);
  const auto errors = [&](const FrameMotion& motion) {
    const Camera colour = calibration.colour;
    std::vector<double> off_surface_m, off_pixel;
    for (const Feature& feature : detector.detect(maps, motion)) {
      off_surface_m.push_back(std::abs(scene.distance(feature.p_camera)));
      const PinholeParams half = colour.pinhole().half();
      const Eigen::Vector3d c = calibration.T_colour_depth * feature.p_camera;
      off_pixel.push_back(std::hypot(
          c.x() / c.z() * static_cast<double>(half.fx) + static_cast<double>(half.cx) - feature.pixel.x(),
          c.y() / c.z() * static_cast<double>(half.fy) + static_cast<double>(half.cy) - feature.pixel.y()));
    }
    std::sort(off_surface_m.begin(), off_surface_m.end());
    std::sort(off_pixel.begin(), off_pixel.end());
    EXPECT_GT(off_surface_m.size(), 50U);
    return std::pair(off_surface_m.at(off_surface_m.size() / 2), off_pixel.at(off_pixel.size() * 9 / 10));
  };
  const auto [aware_m, aware_px] = errors(FrameMotion(maps, options.velocity));
  const auto [unaware_m, unaware_px] = errors({});
  EXPECT_LT(aware_m, 0.5 * unaware_m);
  EXPECT_LT(aware_px, 0.1);
}

}  // namespace
}  // namespace kt::test
