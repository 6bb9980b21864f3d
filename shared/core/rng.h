// Counter-based random numbers: the value depends on (seed, stream, counter) alone, never on call order.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <cstdint>

#include "shared/core/host_device.h"

namespace kt {

/// SplitMix64 finaliser (Steele et al. 2014) over a keyed counter.
KT_HOST_DEVICE inline uint64_t random_bits(uint64_t seed, uint64_t stream, uint64_t counter) {
  uint64_t x = seed + 0x9e3779b97f4a7c15ull * (stream + 1);
  for (int round = 0; round < 2; ++round) {
    x += 0x9e3779b97f4a7c15ull * (counter + 1);
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ull;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebull;
    x ^= x >> 31;
  }
  return x;
}

/// Uniform in [0, 1).
KT_HOST_DEVICE inline double random_uniform(uint64_t seed, uint64_t stream, uint64_t counter) {
  return static_cast<double>(random_bits(seed, stream, counter) >> 11) * 0x1.0p-53;
}

/// Approximately standard normal: sum of 12 uniforms minus 6 (range +-6), free of libm so that every machine
/// agrees.
KT_HOST_DEVICE inline double random_normal(uint64_t seed, uint64_t stream, uint64_t counter) {
  double sum = -6.0;
  for (uint64_t k = 0; k < 3; ++k) {
    const uint64_t bits = random_bits(seed, stream, counter * 3 + k);
    for (int part = 0; part < 4; ++part)
      sum += static_cast<double>((bits >> (16 * part)) & 0xffff) * 0x1.0p-16;
  }
  return sum + 12 * 0x1.0p-17;
}

}  // namespace kt
