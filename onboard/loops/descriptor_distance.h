// Distances between descriptors, as integers: exact, the same everywhere.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bit>
#include <cstdint>
#include <cstring>

#include "onboard/loops/feature_extractor.h"

namespace kt {

/// Bits that differ, or the sum of squares of the differences; so that its square root, or itself, is the
/// distance.
inline int32_t descriptor_distance(const DescriptorKind& kind, const uint8_t* a, const uint8_t* b) {
  int32_t distance = 0;
  if (kind.metric == DescriptorMetric::kHamming) {
    int i = 0;
    for (; i + 8 <= kind.bytes; i += 8) {
      uint64_t word_a, word_b;
      std::memcpy(&word_a, a + i, 8);
      std::memcpy(&word_b, b + i, 8);
      distance += std::popcount(word_a ^ word_b);
    }
    for (; i < kind.bytes; ++i) distance += std::popcount(static_cast<unsigned>(a[i] ^ b[i]));
    return distance;
  }
  for (int i = 0; i < kind.bytes; ++i) {
    const int32_t difference = static_cast<int8_t>(a[i]) - static_cast<int8_t>(b[i]);
    distance += difference * difference;
  }
  return distance;
}

/// What `ratio` of distances (best / second best) is in the integers of descriptor_distance.
inline double distance_ratio(const DescriptorKind& kind, double ratio) {
  return kind.metric == DescriptorMetric::kHamming ? ratio : ratio * ratio;
}

}  // namespace kt
