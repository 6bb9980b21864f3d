// Medians and their uncertainty.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/exposure/gain_ratio.h"

#include <algorithm>
#include <cmath>

namespace kt {
namespace {

// What medians of many cells share: shine, vignetting, light that bounces.
constexpr double kSharedSigma = 0.005;
// Cells that err independently, of those there are: what they show is smooth, and so are errors of the poses.
constexpr double kIndependentShare = 0.1;

float median(std::vector<float> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

float median_distance(const std::vector<float>& values, float from) {
  std::vector<float> distances;
  distances.reserve(values.size());
  for (const float value : values) distances.push_back(std::abs(value - from));
  return median(std::move(distances));
}

}  // namespace

GainRatio gain_ratio(const LogRatios& ratios) {
  constexpr double kSigmaOfDeviation = 1.4826, kSigmaOfMedian = 1.2533;  // of a normal distribution
  GainRatio result;
  for (size_t c = 0; c < kColourChannels; ++c) {
    if (ratios[c].size() < kMinCells) continue;
    const float middle = median(ratios[c]);
    const double sigma = kSigmaOfDeviation * static_cast<double>(median_distance(ratios[c], middle));
    const double independent = kIndependentShare * static_cast<double>(ratios[c].size());
    result[c] = {static_cast<double>(middle),
                 std::hypot(kSharedSigma, kSigmaOfMedian * sigma / std::sqrt(independent))};
  }
  return result;
}

std::optional<double> disagreement(const LogRatios& ratios, const ChannelValues& expected) {
  double sum = 0;
  int channels = 0;
  for (size_t c = 0; c < kColourChannels; ++c) {
    if (ratios[c].size() < kMinCells) continue;
    sum += static_cast<double>(median_distance(ratios[c], static_cast<float>(expected[c])));
    ++channels;
  }
  if (channels == 0) return std::nullopt;
  return sum / channels;
}

}  // namespace kt
