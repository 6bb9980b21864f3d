// From logarithms to factors.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/exposure/frame_gains.h"

#include <algorithm>
#include <cmath>

namespace kt {
namespace {

// The gain that `better` prefers to all others.
template <typename Better>
ChannelValues extreme(const std::map<int64_t, ChannelValues>& log_gains, const Better& better) {
  if (log_gains.empty()) return {1, 1, 1};
  ChannelValues found = log_gains.begin()->second;
  for (const auto& [sequence, log_gain] : log_gains) {
    for (size_t c = 0; c < kColourChannels; ++c) found[c] = better(found[c], log_gain[c]);
  }
  return {std::exp(found[0]), std::exp(found[1]), std::exp(found[2])};
}

}  // namespace

Vec3f FrameGains::factor(int64_t sequence) const {
  const auto found = log_gains.find(sequence);
  if (!are_applied || found == log_gains.end()) return {1, 1, 1};
  const auto factor = [&](size_t c) { return static_cast<float>(std::exp(-found->second[c])); };
  return {factor(0), factor(1), factor(2)};
}

ChannelValues FrameGains::lowest() const {
  return extreme(log_gains, [](double a, double b) { return std::min(a, b); });
}

ChannelValues FrameGains::highest() const {
  return extreme(log_gains, [](double a, double b) { return std::max(a, b); });
}

}  // namespace kt
