// Twists per row from the twist per second.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/preprocess/frame_motion.h"

#include <cmath>

namespace kt {
namespace {

constexpr double kLargestDelay_s = 0.1;  // beyond, the stamps are not of one clock

}  // namespace

RowMotion row_motion(const Vector6d& velocity, double readout_s, const PinholeParams& camera) {
  const Eigen::Matrix<float, 6, 1> per_row = (velocity * (readout_s / camera.height)).cast<float>();
  return {{per_row(0), per_row(1), per_row(2)},
          {per_row(3), per_row(4), per_row(5)},
          0.5f * static_cast<float>(camera.height - 1)};
}

FrameMotion::FrameMotion(const FrameMaps& maps, const Vector6d& velocity)
    : velocity_(velocity), readout_s_(maps.readout_s) {
  const double delay_s = static_cast<double>(maps.colour_timestamp_us - maps.timestamp_us) * 1e-6;
  if (std::abs(delay_s) <= kLargestDelay_s) T_depth_colour_time_ = exp_se3(velocity * delay_s);
  is_still_ = velocity.isZero(0) || (readout_s_ == 0 && delay_s == 0);
}

RowMotion FrameMotion::depth_rows(const PinholeParams& camera) const {
  return row_motion(velocity_, readout_s_, camera);
}

RowMotion FrameMotion::colour_rows(const PinholeParams& camera, const Pose& T_colour_depth) const {
  Vector6d twist;  // of the same motion, in the colour camera
  twist.head<3>() = T_colour_depth.linear() * velocity_.head<3>();
  twist.tail<3>() = T_colour_depth.linear() * velocity_.tail<3>() -
                    twist.head<3>().cross(Eigen::Vector3d(T_colour_depth.translation()));
  return row_motion(twist, readout_s_, camera);
}

}  // namespace kt
