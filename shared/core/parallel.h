// A loop over independent pieces of work on several threads, for offline work; kernels run on shared/exec.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace kt {

/// `threads` as asked for, 0 meaning one per core that this process may use.
inline int thread_count(int threads) {
  return threads > 0 ? threads : static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
}

/// Calls work(i) once for every i in [0, count), in any order, on the calling thread and up to `threads` - 1
/// others (0 = one thread per core), and returns when all are done. Threads start and end with the call, so a
/// piece of work should be worth some 100 us in all. The first exception keeps the rest from starting and is
/// thrown again.
template <typename Work>
void for_each_in_parallel(int64_t count, int threads, const Work& work) {
  std::atomic<int64_t> next{0};
  std::exception_ptr failure;
  std::mutex failure_mutex;
  const auto worker = [&] {
    for (int64_t i = next++; i < count; i = next++) {
      try {
        work(i);
      } catch (...) {
        next = count;
        const std::lock_guard lock(failure_mutex);
        if (!failure) failure = std::current_exception();
      }
    }
  };
  {
    std::vector<std::jthread> others;
    for (int64_t t = 1; t < std::min<int64_t>(thread_count(threads), count); ++t) others.emplace_back(worker);
    worker();
  }
  if (failure) std::rethrow_exception(failure);
}

}  // namespace kt
