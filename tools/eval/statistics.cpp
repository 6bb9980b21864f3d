// Means, deviations and quantiles.
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/eval/statistics.h"

#include <algorithm>
#include <cmath>

#include "shared/core/check.h"

namespace kt {

Statistics summarise(const std::vector<double>& errors) {
  KT_CHECK(!errors.empty());
  const double count = static_cast<double>(errors.size());
  Statistics result;
  double sum = 0, sum_of_squares = 0, squared_deviations = 0;
  for (const double error : errors) sum += error, sum_of_squares += error * error;
  result.mean = sum / count;
  result.rmse = std::sqrt(sum_of_squares / count);
  for (const double error : errors) squared_deviations += (error - result.mean) * (error - result.mean);
  result.standard_deviation = std::sqrt(squared_deviations / count);
  const auto [min, max] = std::minmax_element(errors.begin(), errors.end());
  result.min = *min;
  result.max = *max;
  result.median = quantile(errors, 0.5);
  result.p95 = quantile(errors, 0.95);
  return result;
}

double quantile(std::vector<double> values, double q) {
  KT_CHECK(!values.empty() && q >= 0 && q <= 1);
  const double position = q * static_cast<double>(values.size() - 1);
  const auto below = values.begin() + static_cast<std::ptrdiff_t>(position);
  std::nth_element(values.begin(), below, values.end());
  const double low = *below;
  const double high = below + 1 == values.end() ? low : *std::min_element(below + 1, values.end());
  return low + (position - std::floor(position)) * (high - low);
}

}  // namespace kt
