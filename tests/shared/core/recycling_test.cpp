// Blocks that are used again.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/core/recycling.h"

#include <algorithm>
#include <cstdint>
#include <gtest/gtest.h>
#include <iterator>
#include <thread>
#include <vector>

namespace kt::test {
namespace {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kRecycles = false;
#else
constexpr bool kRecycles = true;
#endif

std::vector<size_t> sizes() {
  std::vector<size_t> sizes;
  for (size_t bytes = 0; bytes < 600; ++bytes) sizes.push_back(bytes);
  for (size_t power = 1024; power <= (32u << 20); power *= 2)
    sizes.insert(sizes.end(), {power - 1, power, power + 1, power + power / 4, power + power / 4 + 1});
  return sizes;
}

TEST(Recycling, AGivenBlockIsTakenAgain) {
  if (!kRecycles) GTEST_SKIP() << "sanitizers see the wrong use of a block only once it is free";
  for (const size_t bytes : {size_t{8}, size_t{350}, size_t{640 * 480 * 3}, size_t{16u << 20}}) {
    void* const block = take_block(bytes);
    give_back_block(block, bytes);
    void* const again = take_block(bytes);
    EXPECT_EQ(again, block) << bytes;
    void* const other = take_block(bytes);
    EXPECT_NE(other, again) << bytes;
    give_back_block(other, bytes);
    give_back_block(again, bytes);
  }
}

TEST(Recycling, BlocksOfAllSizesHoldWhatTheyPromise) {
  struct Held {
    uint8_t* block;
    size_t bytes;
    uint8_t mark;
  };
  std::vector<Held> held;
  for (int round = 0; round < 3; ++round) {
    for (const size_t bytes : sizes()) {
      // What was given back must serve the largest size that may get it.
      auto* const block = static_cast<uint8_t*>(take_block(bytes));
      EXPECT_EQ(reinterpret_cast<uintptr_t>(block) % alignof(std::max_align_t), 0u);
      const auto mark = static_cast<uint8_t>(held.size() + 1);
      std::fill_n(block, bytes, mark);
      held.push_back({block, bytes, mark});
    }
    for (const Held& h : held) {
      EXPECT_TRUE(std::all_of(h.block, h.block + h.bytes, [&](uint8_t byte) { return byte == h.mark; }))
          << h.bytes;
      give_back_block(h.block, h.bytes);
    }
    held.clear();
  }
}

TEST(Recycling, ContainersMoveBetweenThreads) {
  RecycledQueue<RecycledVector<int>> queue;
  std::thread([&] {
    for (int i = 0; i < 1000; ++i) queue.emplace_back(static_cast<size_t>(1 + i % 50), i);
  }).join();
  std::vector<std::thread> readers;
  std::vector<RecycledVector<int>> taken(std::make_move_iterator(queue.begin()),
                                         std::make_move_iterator(queue.end()));
  queue.clear();
  for (size_t t = 0; t < 4; ++t) {
    readers.emplace_back([&, t] {
      for (size_t i = t; i < taken.size(); i += 4) {
        RecycledVector<int> copy = taken[i];
        EXPECT_EQ(copy, RecycledVector<int>(1 + i % 50, static_cast<int>(i)));
        taken[i] = {};
      }
    });
  }
  for (std::thread& reader : readers) reader.join();
}

TEST(Recycling, RefusesWhatNoMemoryHolds) {
  EXPECT_THROW(Recycling<int64_t>().allocate(SIZE_MAX / 4), std::bad_alloc);
}

}  // namespace
}  // namespace kt::test
