// A pool with one queue of blocks under one lock: blocks are coarse, so the lock is not felt.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/exec/thread_pool.h"

#include <chrono>
#include <exception>
#include <string>

#include "shared/core/check.h"

namespace kt::exec {
namespace {

// Looks for up to 50 us whether `condition` holds; the caller sleeps where it does not.
template <typename Condition>
void look_for(const Condition& condition) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::microseconds(50);
  while (!condition() && std::chrono::steady_clock::now() < end) {
  }
}

}  // namespace

ThreadPool::ThreadPool(int threads) {
  KT_CHECK(threads >= 1);
  try {
    for (int i = 1; i < threads; ++i) workers_.emplace_back([this] { work(); });
  } catch (const std::exception& failure) {  // of the system, or for want of memory
    const size_t started = workers_.size() + 1;
    stop();
    throw Error("only " + std::to_string(started) + " of " + std::to_string(threads) +
                " threads could be started (" + failure.what() +
                "): use fewer (--threads), or raise the limits on threads and memory (ulimit -u, ulimit -v)");
  }
}

ThreadPool::~ThreadPool() { stop(); }

void ThreadPool::stop() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  work_arrived_.notify_all();
  for (std::thread& worker : workers_) worker.join();
}

// Takes and runs a block; false where none is left. Holds `lock` before and after, not during.
bool ThreadPool::do_one_block(std::unique_lock<std::mutex>& lock) {
  if (open_blocks_ == 0) return false;
  const int64_t block = next_block_++;
  --open_blocks_;
  const Call call = call_;
  const void* context = context_;
  lock.unlock();
  call(context, block);
  lock.lock();
  if (--unfinished_ == 0) work_done_.notify_one();
  return true;
}

void ThreadPool::run_erased(int64_t blocks, Call call, const void* context) {
  const std::lock_guard turn(turn_);
  std::unique_lock lock(mutex_);
  call_ = call;
  context_ = context;
  next_block_ = 0;
  unfinished_ = blocks;
  open_blocks_ = blocks;
  work_arrived_.notify_all();
  while (do_one_block(lock)) {
  }
  lock.unlock();
  look_for([this] { return unfinished_ == 0; });
  lock.lock();
  work_done_.wait(lock, [this] { return unfinished_ == 0; });
}

void ThreadPool::work() {
  std::unique_lock lock(mutex_);
  while (!stopping_) {
    while (do_one_block(lock)) {
    }
    lock.unlock();
    look_for([this] { return open_blocks_ > 0; });
    lock.lock();
    work_arrived_.wait(lock, [this] { return open_blocks_ > 0 || stopping_; });
  }
}

}  // namespace kt::exec
