// Gains of many views from ratios between some of them.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include "offboard/exposure/gain_ratio.h"

namespace kt {

/// What the views `from` and `to` have in common.
struct GainEdge {
  size_t from = 0, to = 0;
  GainRatio ratio;  ///< of `to` over `from`
};

/// Logarithms of the gains x of `count` views, per channel:
///   sum rho((x_to - x_from - r) / sigma) + sum ((x_{k+1} - x_k) / 0.3)^2 + sum (x_k / 1)^2  ->  min
/// with Cauchy's rho by reweighting. The last two terms say little: they bind views without ratios to their
/// neighbours in time, and keep the mean of all at gain 1.
std::vector<ChannelValues> solve_log_gains(size_t count, std::span<const GainEdge> edges);

}  // namespace kt
