// The writer thread of a log.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/publish/log_sink.h"

#include <condition_variable>
#include <exception>
#include <mutex>
#include <optional>
#include <string>
#include <utility>

#include "shared/core/check.h"
#include "shared/core/recycling.h"

namespace kt {
namespace {

using Clock = std::chrono::steady_clock;

// A few frames with everything that belongs to them: enough to ride out a slow write, little memory.
constexpr size_t kQueueCapacity = 32;

// A signal handler sets a flag and wakes nobody.
constexpr std::chrono::milliseconds kLookForEnd{50};

}  // namespace

struct LogSink::Queue {
  Queue(const std::filesystem::path& path, const Options& options, const End& the_end)
      : end(the_end), store(path, options) {
    stock(items, kQueueCapacity);
  }

  const End end;
  LogStore store;  ///< the thread's alone

  std::mutex mutex;  ///< guards what follows
  std::condition_variable changed;
  RecycledQueue<LogItem> items;
  StorageState state;
  Clock::duration waited{0};  ///< since the end was called
  bool stopping = false, is_late = false, is_done = false;
  std::exception_ptr failure;

  void run();
  void write_next(std::unique_lock<std::mutex>& lock);
  template <typename Ready>
  bool wait_for_disk(std::unique_lock<std::mutex>& lock, const Ready& ready);
};

// Waits for the thread to make progress; false where that has taken too long since the end was called.
template <typename Ready>
bool LogSink::Queue::wait_for_disk(std::unique_lock<std::mutex>& lock, const Ready& ready) {
  if (!end.called) {
    changed.wait(lock, ready);
    return true;
  }
  while (!ready()) {
    const bool is_called = end.called->load();
    is_late = is_late || (is_called && waited >= end.patience);
    if (is_late) return false;
    const auto begin = Clock::now();
    changed.wait_for(lock, kLookForEnd, ready);
    if (is_called) waited += Clock::now() - begin;
  }
  return true;
}

void LogSink::Queue::run() {
  std::unique_lock lock(mutex);
  try {
    while (true) {
      const auto ready = [this] { return !items.empty() || stopping; };
      if (const auto due = store.next_sync(); due == Clock::time_point::max()) {
        changed.wait(lock, ready);
      } else {
        changed.wait_until(lock, due, ready);
      }
      if (items.empty() && stopping) break;
      write_next(lock);
    }
    lock.unlock();
    store.close();
    lock.lock();
  } catch (...) {
    if (!lock.owns_lock()) lock.lock();
    failure = std::current_exception();
    items.clear();
  }
  is_done = true;
  changed.notify_all();
}

void LogSink::Queue::write_next(std::unique_lock<std::mutex>& lock) {
  std::optional<LogItem> item;
  if (!items.empty()) {
    item = std::move(items.front());
    items.pop_front();
    changed.notify_all();
  }
  const bool too_late = is_late;
  lock.unlock();
  if (item && too_late) store.drop(*item);
  if (item && !too_late) store.store(*item);
  store.sync_if_due();
  const StorageState now = store.state();
  lock.lock();
  state = now;
}

LogSink::LogSink(const std::filesystem::path& path, const Options& options, const End& end)
    : queue_(std::make_shared<Queue>(path, options, end)), thread_([queue = queue_] { queue->run(); }) {}

LogSink::~LogSink() { stop(); }

void LogSink::put(LogItem item) {
  Queue& queue = *queue_;
  std::unique_lock lock(queue.mutex);
  KT_CHECK(!queue.stopping, "the log is closed");
  // What is put too late is dropped and counted by the thread.
  queue.wait_for_disk(lock, [&queue] { return queue.items.size() < kQueueCapacity || queue.failure; });
  if (queue.failure) std::rethrow_exception(queue.failure);
  queue.items.push_back(std::move(item));
  queue.changed.notify_all();
}

void LogSink::stop() {
  if (!thread_.joinable()) return;
  Queue& queue = *queue_;
  std::unique_lock lock(queue.mutex);
  queue.stopping = true;
  queue.changed.notify_all();
  // Where it is late, the thread still drops what waits, unless a system call holds it.
  constexpr std::chrono::seconds kForDropping{1};
  const auto is_done = [&queue] { return queue.is_done; };
  const bool in_time =
      queue.wait_for_disk(lock, is_done) || queue.changed.wait_for(lock, kForDropping, is_done);
  lock.unlock();
  if (in_time) return thread_.join();
  thread_.detach();
}

void LogSink::close() {
  stop();
  Queue& queue = *queue_;
  const std::unique_lock lock(queue.mutex);
  if (queue.failure) std::rethrow_exception(queue.failure);
  if (!queue.is_done) {
    throw Error("the disk of the log " + queue.store.path().string() +
                " answers no more: " + std::to_string(queue.items.size() + 1) +
                " messages were not stored; what was stored before is intact");
  }
}

StorageState LogSink::storage() const {
  const std::lock_guard lock(queue_->mutex);
  return queue_->state;
}

}  // namespace kt
