// How lists that only grow stay bounded.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

namespace kt {

/// Where `oldest_first` has `capacity` elements every second of the older half goes: the newest stay, and old
/// ones become sparser with age but never none. At least one element goes then; returns whether any went.
template <typename T>
bool make_room(std::vector<T>& oldest_first, size_t capacity) {
  if (oldest_first.size() < capacity) return false;
  size_t index = 0;
  const size_t older = oldest_first.size() / 2;
  std::erase_if(oldest_first, [&](const T&) { return index < older && index++ % 2 == 1; });
  if (oldest_first.size() >= capacity)
    oldest_first.erase(oldest_first.begin());  // a half too small to thin out
  return true;
}

}  // namespace kt
