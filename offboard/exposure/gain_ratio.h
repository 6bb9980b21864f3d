// How much brighter one view is than another, robustly.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "offboard/exposure/exposure_view.h"

namespace kt {

/// Logarithm of the gain of one view over that of another, of one channel.
struct ChannelRatio {
  double log_ratio = 0;
  double sigma = 0;  ///< its standard deviation
};
using GainRatio = std::array<std::optional<ChannelRatio>, kColourChannels>;

/// Fewer cells in common say nothing.
inline constexpr size_t kMinCells = 60;

/// Medians; nothing for a channel of fewer than kMinCells cells.
GainRatio gain_ratio(const LogRatios& ratios);

/// Mean over the channels of the median |log ratio - expected|: a hundredth is one per cent of the level.
/// Nothing where no channel has kMinCells cells.
std::optional<double> disagreement(const LogRatios& ratios, const ChannelValues& expected);

}  // namespace kt
