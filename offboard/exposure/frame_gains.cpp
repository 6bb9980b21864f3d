// From logarithms to factors.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/exposure/frame_gains.h"

#include <cmath>

namespace kt {

Vec3f FrameGains::factor(int64_t sequence) const {
  const auto found = log_gains.find(sequence);
  if (!figures.are_applied || found == log_gains.end()) return {1, 1, 1};
  const auto factor = [&](size_t c) { return static_cast<float>(std::exp(-found->second[c])); };
  return {factor(0), factor(1), factor(2)};
}

}  // namespace kt
