// Mutual nearest neighbours, node by node.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/loops/descriptor_matcher.h"

#include <algorithm>

#include "onboard/loops/descriptor_distance.h"
#include "onboard/tracking/nearest_two.h"

namespace kt {

IndexedDescriptors::IndexedDescriptors(std::span<const uint8_t> all, std::span<const int32_t> nodes)
    : descriptors(all) {
  for (size_t i = 0; i < nodes.size(); ++i) entries.push_back({nodes[i], static_cast<int32_t>(i)});
  std::sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) {
    return a.node != b.node ? a.node < b.node : a.index < b.index;
  });
}

std::vector<FeatureMatch> match_descriptors(const DescriptorKind& kind, const IndexedDescriptors& a,
                                            const IndexedDescriptors& b, double max_ratio) {
  const double ratio = distance_ratio(kind, max_ratio);
  std::vector<NearestTwo> nearest_a(a.entries.size()), nearest_b(b.entries.size());
  const auto end_of_node = [](const auto& entries, size_t begin) {
    size_t end = begin;
    while (end < entries.size() && entries[end].node == entries[begin].node) ++end;
    return end;
  };
  const auto at = [&kind](const IndexedDescriptors& side, size_t entry) {
    return side.descriptors.data() +
           static_cast<size_t>(side.entries[entry].index) * static_cast<size_t>(kind.bytes);
  };
  for (size_t begin_a = 0, begin_b = 0; begin_a < a.entries.size() && begin_b < b.entries.size();) {
    const int32_t node_a = a.entries[begin_a].node, node_b = b.entries[begin_b].node;
    if (node_a != node_b) {
      ++(node_a < node_b ? begin_a : begin_b);
      continue;
    }
    const size_t end_a = end_of_node(a.entries, begin_a), end_b = end_of_node(b.entries, begin_b);
    for (size_t i = begin_a; i < end_a; ++i) {
      for (size_t j = begin_b; j < end_b; ++j) {
        const int32_t distance = descriptor_distance(kind, at(a, i), at(b, j));
        nearest_a[i].see(static_cast<int>(j), distance);
        nearest_b[j].see(static_cast<int>(i), distance);
      }
    }
    begin_a = end_a;
    begin_b = end_b;
  }
  std::vector<FeatureMatch> matches;
  for (size_t i = 0; i < nearest_a.size(); ++i) {
    const NearestTwo& best = nearest_a[i];
    if (!best.is_clear(ratio)) continue;
    const auto j = static_cast<size_t>(best.index);
    if (nearest_b[j].index != static_cast<int>(i)) continue;
    matches.push_back({a.entries[i].index, b.entries[j].index});
  }
  std::sort(matches.begin(), matches.end(),
            [](const FeatureMatch& x, const FeatureMatch& y) { return x.a < y.a; });
  return matches;
}

}  // namespace kt
