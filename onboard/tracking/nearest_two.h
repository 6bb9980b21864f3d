// The nearest of several descriptors, and how clearly it is.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <limits>

namespace kt {

/// Is shown one distance after the other.
struct NearestTwo {
  static constexpr int32_t kNone = std::numeric_limits<int32_t>::max();
  int32_t distance = kNone, second = kNone;
  int index = -1;

  void see(int other, int32_t other_distance) {
    if (other_distance < distance) {
      second = distance;
      distance = other_distance;
      index = other;
    } else if (other_distance < second) {
      second = other_distance;
    }
  }
  /// Whether there is one, nearer than `ratio` times the second nearest (Lowe 2004).
  bool is_clear(double ratio) const {
    return index >= 0 && (second == kNone || distance < ratio * static_cast<double>(second));
  }
};

}  // namespace kt
