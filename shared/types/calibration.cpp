// Sanity checks of a calibration.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/types/calibration.h"

#include <cmath>

namespace kt {

bool Calibration::is_equal_to(const Calibration& other) const {
  return depth == other.depth && colour == other.colour &&
         T_colour_depth.matrix() == other.T_colour_depth.matrix() && depth_unit_m == other.depth_unit_m &&
         invalid_depth == other.invalid_depth && readout_s == other.readout_s &&
         stamp_delay_s == other.stamp_delay_s;
}

bool Calibration::is_registered() const {
  return depth == colour && T_colour_depth.matrix().isApprox(Eigen::Matrix4d::Identity(), 1e-12);
}

std::string Calibration::problem() const {
  if (const std::string text = depth.problem(); !text.empty()) return "depth camera: " + text;
  if (const std::string text = colour.problem(); !text.empty()) return "colour camera: " + text;
  return range_problem();
}

std::string Calibration::range_problem() const {
  if (const std::string text = depth.range_problem(); !text.empty()) return "depth camera: " + text;
  if (const std::string text = colour.range_problem(); !text.empty()) return "colour camera: " + text;
  if (!is_valid_pose(T_colour_depth)) return "T_colour_depth is not a rigid transform";
  if (T_colour_depth.translation().norm() > 1) return "the cameras stand more than 1 m apart";
  if (!(depth_unit_m >= 1e-6 && depth_unit_m <= 0.1)) return "depth_unit_m must lie in [1e-6, 0.1]";
  if (!(std::abs(readout_s) <= 0.2)) return "readout_s must lie in [-0.2, 0.2]";
  if (!(std::abs(stamp_delay_s) <= 1)) return "stamp_delay_s must lie in [-1, 1]";
  return {};
}

}  // namespace kt
