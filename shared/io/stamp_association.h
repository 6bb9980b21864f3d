// Pairs two lists of time stamps as the TUM benchmark's associate.py does.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace kt {

struct StampPair {
  size_t first = 0, second = 0;  ///< indices into the two lists
  friend bool operator==(const StampPair&, const StampPair&) = default;
};

/// The TUM benchmark's window.
constexpr int64_t kMaxStampDifference_us = 20'000;

/// Takes the closest pair of stamps (us), then the closest of what is left, and so on while they differ by
/// less than `max_difference_us`; ties go to the earlier stamps. Each stamp is used once. The lists need no
/// order; the result is sorted by the first list's stamps. Takes O(n log n) time and O(n) memory.
std::vector<StampPair> associate_stamps(std::span<const int64_t> first_us, std::span<const int64_t> second_us,
                                        int64_t max_difference_us = kMaxStampDifference_us);

}  // namespace kt
