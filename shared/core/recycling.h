// Memory of what comes and goes with every frame, images and messages: given back blocks are used again.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <new>
#include <vector>

namespace kt {

/// A block of `bytes`, aligned for every standard type: one that was given back, else one of the system's.
/// From any thread. Throws std::bad_alloc.
void* take_block(size_t bytes);
/// Keeps a block for the next that takes as many bytes; where much is kept already, or too many sizes, it
/// goes back to the system.
void give_back_block(void* block, size_t bytes) noexcept;

/// Allocator of standard containers that takes its memory so. A loop over frames asks the system for none
/// once it has as many of each size as it holds at a time.
template <typename T>
struct Recycling {
  using value_type = T;
  static_assert(alignof(T) <= alignof(std::max_align_t));

  Recycling() = default;
  template <typename U>
  Recycling(const Recycling<U>&) {}  // containers ask for nodes of other types

  T* allocate(size_t count) {
    if (count > SIZE_MAX / sizeof(T)) throw std::bad_alloc();
    return static_cast<T*>(take_block(count * sizeof(T)));
  }
  void deallocate(T* block, size_t count) noexcept { give_back_block(block, count * sizeof(T)); }

  friend bool operator==(const Recycling&, const Recycling&) { return true; }
};

template <typename T>
using RecycledVector = std::vector<T, Recycling<T>>;
template <typename T>
using RecycledQueue = std::deque<T, Recycling<T>>;

/// Takes the memory of `count` elements at once, for a queue that will not take any while it holds fewer.
template <typename T>
void stock(RecycledQueue<T>& queue, size_t count) {
  RecycledQueue<T>(count).swap(queue);
  queue.clear();
}

}  // namespace kt
