// The CPU threads that kernels run on.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <thread>
#include <vector>

namespace kt::exec {

/// Runs numbered blocks of work on a fixed set of threads, the calling one among them. A frame makes some
/// forty short launches: idle threads look for the next one for a few microseconds, then sleep, so that they
/// neither add latency nor burn a core that others need.
class ThreadPool {
 public:
  /// `threads` >= 1 in all. Throws kt::Error where the system does not grant as many.
  explicit ThreadPool(int threads);
  ~ThreadPool();
  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;

  int threads() const { return static_cast<int>(workers_.size()) + 1; }

  /// Calls body(b) once for every b in [0, blocks), on any thread in any order, and returns when all are
  /// done. `body` must not throw and not call run. Calls from several threads take turns.
  template <typename Body>
  void run(int64_t blocks, const Body& body) {
    if (workers_.empty() || blocks <= 1) {
      for (int64_t b = 0; b < blocks; ++b) body(b);
      return;
    }
    run_erased(
        blocks, [](const void* context, int64_t b) { (*static_cast<const Body*>(context))(b); }, &body);
  }

 private:
  using Call = void (*)(const void* context, int64_t block);
  void run_erased(int64_t blocks, Call call, const void* context);
  void work();
  void stop();
  bool do_one_block(std::unique_lock<std::mutex>& lock);

  std::mutex turn_;   // held by the caller whose run it is
  std::mutex mutex_;  // guards what follows, but for the two atomics, which are also read without it
  std::condition_variable work_arrived_, work_done_;
  Call call_ = nullptr;
  const void* context_ = nullptr;
  int64_t next_block_ = 0;
  std::atomic<int64_t> open_blocks_{0};  // not yet taken
  std::atomic<int64_t> unfinished_{0};   // not yet done
  bool stopping_ = false;
  std::vector<std::thread> workers_;
};

}  // namespace kt::exec
