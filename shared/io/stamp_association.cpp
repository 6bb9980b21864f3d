// Greedy best-first matching of time stamps.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/io/stamp_association.h"

#include <algorithm>
#include <numeric>
#include <tuple>

namespace kt {
namespace {

std::vector<size_t> order_by_stamp(std::span<const int64_t> stamps_us) {
  std::vector<size_t> order(stamps_us.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](size_t a, size_t b) { return stamps_us[a] < stamps_us[b]; });
  // Of equal stamps only the first counts; this also bounds the number of candidates below.
  const auto last = std::unique(order.begin(), order.end(),
                                [&](size_t a, size_t b) { return stamps_us[a] == stamps_us[b]; });
  order.erase(last, order.end());
  return order;
}

}  // namespace

std::vector<StampPair> associate_stamps(std::span<const int64_t> first_us, std::span<const int64_t> second_us,
                                        int64_t max_difference_us) {
  struct Candidate {
    int64_t difference_us, a_us, b_us;
    StampPair pair;
  };
  const std::vector<size_t> order_a = order_by_stamp(first_us), order_b = order_by_stamp(second_us);
  std::vector<Candidate> candidates;
  size_t begin = 0;
  for (const size_t a : order_a) {
    while (begin < order_b.size() && second_us[order_b[begin]] <= first_us[a] - max_difference_us) ++begin;
    for (size_t k = begin; k < order_b.size(); ++k) {
      const size_t b = order_b[k];
      if (second_us[b] >= first_us[a] + max_difference_us) break;
      candidates.push_back({std::abs(first_us[a] - second_us[b]), first_us[a], second_us[b], {a, b}});
    }
  }
  std::sort(candidates.begin(), candidates.end(), [](const Candidate& x, const Candidate& y) {
    return std::tie(x.difference_us, x.a_us, x.b_us) < std::tie(y.difference_us, y.a_us, y.b_us);
  });

  std::vector<char> used_a(first_us.size()), used_b(second_us.size());
  std::vector<StampPair> pairs;
  for (const Candidate& candidate : candidates) {
    const auto [a, b] = candidate.pair;
    if (used_a[a] || used_b[b]) continue;
    used_a[a] = used_b[b] = 1;
    pairs.push_back(candidate.pair);
  }
  std::sort(pairs.begin(), pairs.end(),
            [&](const StampPair& x, const StampPair& y) { return first_us[x.first] < first_us[y.first]; });
  return pairs;
}

}  // namespace kt
