// Chains the steps of the exact path, each with its error.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/synth/wheel_odometry.h"

#include <cmath>

#include "shared/core/rng.h"

namespace kt {
namespace {

constexpr int64_t kPeriod_us = 20'000;

// Apart from what the pictures draw from the mission's seed.
constexpr uint64_t kSeedOfWheels = 0x0d0;

}  // namespace

std::vector<MotionSample> wheel_odometry(const SyntheticMission& mission, const WheelFlaws& flaws) {
  const int64_t first_us = mission.groundtruth().front().timestamp_us;
  const int64_t last_us = mission.groundtruth().back().timestamp_us;
  const double period_s = static_cast<double>(kPeriod_us) * 1e-6;
  std::vector<MotionSample> samples;
  MotionSample sample;
  sample.rotation_sigma = flaws.rotation_sigma;
  sample.translation_sigma = flaws.translation_sigma;
  Pose T_world_last = mission.T_world_camera_at(first_us);
  for (int64_t stamp_us = first_us; stamp_us <= last_us; stamp_us += kPeriod_us) {
    sample.sequence = static_cast<int64_t>(samples.size());
    sample.timestamp_us = stamp_us;
    if (!samples.empty()) {
      const Pose T_world_camera = mission.T_world_camera_at(stamp_us);
      Pose T_last_camera = T_world_last.inverse() * T_world_camera;
      T_last_camera.translation() *= 1 + flaws.scale_error;
      Vector6d error;
      for (int axis = 0; axis < 6; ++axis) {
        error[axis] = (axis < 3 ? flaws.rotation_sigma : flaws.translation_sigma) * std::sqrt(period_s) *
                      random_normal(mission.seed() ^ kSeedOfWheels, static_cast<uint64_t>(axis),
                                    static_cast<uint64_t>(sample.sequence));
      }
      const Eigen::Vector3d up_camera = T_world_camera.linear().transpose() * Eigen::Vector3d::UnitZ();
      error.head<3>() += flaws.yaw_drift_rps * period_s * up_camera;
      sample.T_prior = orthonormalised(sample.T_prior * T_last_camera * exp_se3(error));
      T_world_last = T_world_camera;
    }
    samples.push_back(sample);
  }
  return samples;
}

}  // namespace kt
