// Tests of the parallel loop: every piece once, on any number of threads, and what happens to exceptions.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/core/parallel.h"

#include <set>
#include <stdexcept>

#include "gtest/gtest.h"

namespace kt {
namespace {

TEST(Parallel, RunsEveryPieceOnce) {
  for (const int threads : {0, 1, 2, 7}) {
    std::vector<std::atomic<int>> calls(1000);
    for_each_in_parallel(1000, threads, [&](int64_t i) { ++calls[static_cast<size_t>(i)]; });
    for (const auto& count : calls) EXPECT_EQ(count, 1) << threads << " threads";
  }
  for_each_in_parallel(0, 3, [](int64_t) { FAIL() << "there is nothing to do"; });
}

TEST(Parallel, StaysOnTheCallingThreadWhereItIsTheOnlyOne) {
  std::set<std::thread::id> ids;
  for_each_in_parallel(20, 1, [&](int64_t) { ids.insert(std::this_thread::get_id()); });
  EXPECT_EQ(ids, std::set{std::this_thread::get_id()});
}

TEST(Parallel, UsesTheThreadsAskedFor) {
  // Two pieces that wait for each other end only where two threads run them.
  std::atomic<int> arrived{0};
  for_each_in_parallel(2, 2, [&](int64_t) {
    ++arrived;
    while (arrived < 2) std::this_thread::yield();
  });
  EXPECT_EQ(arrived, 2);
}

TEST(Parallel, ThrowsTheFirstExceptionAgainAndStops) {
  for (const int threads : {1, 3}) {
    std::atomic<int> calls{0};
    const auto work = [&](int64_t i) {
      ++calls;
      if (i == 5) throw std::runtime_error("piece 5");
    };
    EXPECT_THROW(for_each_in_parallel(1'000'000, threads, work), std::runtime_error);
    EXPECT_LT(calls, 1'000'000);
  }
}

}  // namespace
}  // namespace kt
