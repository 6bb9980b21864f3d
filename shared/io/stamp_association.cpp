// Greedy best-first matching of time stamps.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/io/stamp_association.h"

#include <algorithm>
#include <functional>
#include <numeric>
#include <queue>
#include <tuple>

namespace kt {
namespace {

std::vector<size_t> distinct_by_stamp(std::span<const int64_t> stamps_us) {
  std::vector<size_t> order(stamps_us.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](size_t a, size_t b) { return stamps_us[a] < stamps_us[b]; });
  // Of equal stamps only the first counts.
  const auto last = std::unique(order.begin(), order.end(),
                                [&](size_t a, size_t b) { return stamps_us[a] == stamps_us[b]; });
  order.erase(last, order.end());
  return order;
}

}  // namespace

std::vector<StampPair> associate_stamps(std::span<const int64_t> first_us, std::span<const int64_t> second_us,
                                        int64_t max_difference_us) {
  // All stamps in one line. The closest pair of what is left always stands side by side in it, so neighbours
  // are the only candidates: memory stays linear however dense the stamps are.
  struct Stamp {
    int64_t us;
    bool is_second;
    size_t index;  // in its own list
    bool operator<(const Stamp& other) const {
      return std::tie(us, is_second) < std::tie(other.us, other.is_second);
    }
  };
  std::vector<Stamp> line;
  for (const size_t i : distinct_by_stamp(first_us)) line.push_back({first_us[i], false, i});
  for (const size_t i : distinct_by_stamp(second_us)) line.push_back({second_us[i], true, i});
  std::sort(line.begin(), line.end());
  constexpr size_t kNone = SIZE_MAX;
  std::vector<size_t> before(line.size()), behind(line.size());
  for (size_t i = 0; i < line.size(); ++i) {
    before[i] = i == 0 ? kNone : i - 1;
    behind[i] = i + 1 == line.size() ? kNone : i + 1;
  }

  using Candidate = std::tuple<int64_t, int64_t, int64_t, size_t, size_t>;  // difference, stamps, left, right
  std::priority_queue<Candidate, std::vector<Candidate>, std::greater<>> candidates;
  const auto consider = [&](size_t left, size_t right) {
    if (left == kNone || right == kNone || line[left].is_second == line[right].is_second) return;
    const int64_t difference_us = line[right].us - line[left].us;
    if (difference_us >= max_difference_us) return;
    const size_t a = line[left].is_second ? right : left, b = line[left].is_second ? left : right;
    candidates.push({difference_us, line[a].us, line[b].us, left, right});
  };
  for (size_t i = 0; i + 1 < line.size(); ++i) consider(i, i + 1);

  std::vector<char> used(line.size());
  std::vector<StampPair> pairs;
  while (!candidates.empty()) {
    const auto [difference_us, a_us, b_us, left, right] = candidates.top();
    candidates.pop();
    if (used[left] || used[right]) continue;
    used[left] = used[right] = 1;
    const bool turned = line[left].is_second;
    pairs.push_back({line[turned ? right : left].index, line[turned ? left : right].index});
    const size_t outer_left = before[left], outer_right = behind[right];
    if (outer_left != kNone) behind[outer_left] = outer_right;
    if (outer_right != kNone) before[outer_right] = outer_left;
    consider(outer_left, outer_right);
  }
  std::sort(pairs.begin(), pairs.end(),
            [&](const StampPair& x, const StampPair& y) { return first_us[x.first] < first_us[y.first]; });
  return pairs;
}

}  // namespace kt
