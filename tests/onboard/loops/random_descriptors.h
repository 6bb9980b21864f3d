// Descriptors drawn at random, of both metrics.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <vector>

#include "onboard/loops/feature_extractor.h"
#include "shared/core/rng.h"

namespace kt::test {

inline std::array<DescriptorKind, 2> small_kinds() {
  return {DescriptorKind{"bits", 4, DescriptorMetric::kHamming},
          DescriptorKind{"bytes", 5, DescriptorMetric::kEuclidean}};
}

inline std::vector<uint8_t> random_descriptors(const DescriptorKind& kind, size_t count, uint64_t seed) {
  std::vector<uint8_t> bytes(count * static_cast<size_t>(kind.bytes));
  for (size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<uint8_t>(random_bits(seed, 0, i));
  return bytes;
}

}  // namespace kt::test
