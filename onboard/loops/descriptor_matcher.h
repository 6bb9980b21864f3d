// Pairs of descriptors that belong together.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include "onboard/loops/feature_extractor.h"
#include "onboard/tracking/feature_aligner.h"

namespace kt {

/// The descriptors of an image, ordered by the vocabulary's node that they lie under (the direct index).
class IndexedDescriptors {
 public:
  /// `nodes` by descriptor; both must outlive this.
  IndexedDescriptors(std::span<const uint8_t> descriptors, std::span<const int32_t> nodes);

  std::span<const uint8_t> descriptors;
  struct Entry {
    int32_t node, index;
  };
  std::vector<Entry> entries;  ///< by node, then index
};

/// Pairs of descriptors under the same node that are each other's nearest, and nearer than `max_ratio` times
/// the second nearest.
std::vector<FeatureMatch> match_descriptors(const DescriptorKind& kind, const IndexedDescriptors& a,
                                            const IndexedDescriptors& b, double max_ratio);

}  // namespace kt
