// Pictures of errors, drawn by gnuplot.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include "tools/eval/surface_error.h"
#include "tools/eval/trajectory_error.h"

namespace kt {

/// The two paths seen along the axis in which they extend least, and the error over time. Throws kt::Error
/// where gnuplot is missing or fails.
void plot_trajectory_error(const AbsoluteTrajectoryError& error, const std::filesystem::path& png);

/// The share of either surface within a distance, over that distance.
void plot_surface_error(const SurfaceError& error, double threshold_m, const std::filesystem::path& png);

}  // namespace kt
