// Summaries of a list of errors.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

namespace kt {

/// All in the unit of the errors; `standard_deviation` divides by n, as numpy does.
struct Statistics {
  double rmse = 0, mean = 0, median = 0, standard_deviation = 0, min = 0, max = 0, p95 = 0;
};

/// Needs at least one value. Sums run in the order given, so equal input gives equal bits.
Statistics summarise(const std::vector<double>& errors);

/// Linear interpolation between the sorted values, `q` in [0, 1]: 0.5 is the median. Needs at least one
/// value.
double quantile(std::vector<double> values, double q);

}  // namespace kt
