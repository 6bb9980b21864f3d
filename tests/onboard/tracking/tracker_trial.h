// A frame tracked against a model of a scene that is known: what the tests of the tracker share.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "onboard/tracking/tracker.h"
#include "tests/onboard/tracking/model_views.h"

namespace kt::test {

// Tracks a rendered frame against an exact view of the scene.
struct Trial {
  AnalyticScene scene = furnished_room();
  Pose T_odom_model = Pose::Identity();
  Pose T_odom_camera = Pose::Identity();  // the truth
  Pose T_odom_guess = Pose::Identity();
  bool has_reference = false;  // an image of the model's pose too
  RenderOptions render_options;
  Calibration calibration = small_calibration();
  TrackingConfig config;
  int model_columns = 1 << 20;
  bool half_model = false;
  Vector6d velocity = Vector6d::Zero();
  Pose T_odom_motion = Pose::Identity();
  Matrix6d motion_information = Matrix6d::Zero();
  exec::Device device = exec::Device::cpu(1);

  Approach approach() const {
    constexpr double kInterval_s = 1 / 30.0;
    return {T_odom_camera * exp_se3(-kInterval_s * velocity), velocity, velocity.isZero(0) ? 0 : kInterval_s};
  }
  TrackResult run() const { return run(render(scene, calibration, T_odom_camera, render_options)); }
  TrackResult run(const RgbdFrame& frame) const {
    const PinholeParams camera = calibration.depth.pinhole();
    Preprocessor preprocessor(device, calibration, {});
    const ModelView model = exact_model_view(
        device, scene, half_model || has_reference ? camera.half() : camera, T_odom_model, model_columns);
    PhotometricReference reference(device, calibration, model.camera.pixel_count());
    if (has_reference)
      reference.take(preprocessor.process(render(scene, calibration, T_odom_model, render_options)), model);
    return Tracker(device, calibration, config)
        .track(preprocessor.process(frame), model, &reference,
               {T_odom_guess, {}, approach(), T_odom_motion, motion_information});
  }
};

}  // namespace kt::test
