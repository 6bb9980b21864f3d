// Tests of the pool of CPU threads: callers beside each other, threads that cannot be had.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/exec/thread_pool.h"

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <sys/resource.h>
#include <unistd.h>

#include "gtest/gtest.h"

#include "shared/core/check.h"

namespace kt::exec {
namespace {

TEST(ThreadPool, RunsEveryBlockOnceForCallersBesideEachOther) {
  ThreadPool pool(3);
  constexpr int kRuns = 300;
  const auto call = [&](std::vector<int>& counts) {
    for (int run = 0; run < kRuns; ++run)
      pool.run(static_cast<int64_t>(counts.size()), [&](int64_t b) { ++counts[static_cast<size_t>(b)]; });
  };
  std::vector<int> first(7), second(64);
  std::thread other([&] { call(second); });
  call(first);
  other.join();
  for (const std::vector<int>& counts : {first, second})
    EXPECT_TRUE(std::all_of(counts.begin(), counts.end(), [](int n) { return n == kRuns; }));
}

TEST(ThreadPool, RefusesFewerThanOneThread) { EXPECT_THROW(ThreadPool(0), LogicError); }

// Ends with 0 where it finds the error, and the program goes on.
[[noreturn]] void ask_for_more_threads_than_fit() {
  int64_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  const rlim_t limit = static_cast<rlim_t>(pages * sysconf(_SC_PAGESIZE)) + (rlim_t{200} << 20);
  const rlimit address_space{limit, limit};
  if (setrlimit(RLIMIT_AS, &address_space) != 0) std::_Exit(2);
  try {
    const ThreadPool pool(1024);
  } catch (const Error& error) {
    int blocks = 0;
    ThreadPool(1).run(3, [&](int64_t) { ++blocks; });
    std::cerr << error.what() << "; then " << blocks << " blocks\n";
    std::_Exit(0);
  }
  std::_Exit(1);
}

TEST(ThreadPoolDeathTest, SaysWhatToDoWhereThreadsCannotBeHad) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "sanitizers need the address space";
#endif
  testing::FLAGS_gtest_death_test_style = "threadsafe";
  EXPECT_EXIT(ask_for_more_threads_than_fit(), testing::ExitedWithCode(0),
              "only [0-9]+ of 1024 threads could be started .*: use fewer \\(--threads\\).*; then 3 blocks");
}

}  // namespace
}  // namespace kt::exec
