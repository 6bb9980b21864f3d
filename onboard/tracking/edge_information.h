// How sure an edge between two good frames is.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "shared/geometry/se3.h"

namespace kt {

/// Information of the left perturbation of T_last_current for an edge of `dt_s` seconds: by what the tracker
/// measured, against the model or else against the last frame, and what another sensor said of the motion
/// (zero: nothing).
Matrix6d edge_information(const Matrix6d& measured, const Matrix6d& sensed, const Pose& T_last_current,
                          double dt_s, bool is_against_model);

}  // namespace kt
