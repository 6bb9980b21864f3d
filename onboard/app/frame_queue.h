// A bounded queue between the thread that reads frames and the one that processes them.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <condition_variable>
#include <deque>
#include <exception>
#include <mutex>
#include <optional>
#include <sys/resource.h>
#include <thread>

#include "onboard/source/frame_source.h"

namespace kt {

/// Reads a source ahead on its own thread, at most `capacity` frames and skipped ones, with the motion
/// samples among them; order and content are the source's, but that kNothingYet is passed on only while
/// nothing else waits. That thread gives way to those that process: on a busy machine images are decoded
/// while the tracker waits, not in its stead.
class FrameQueue {
 public:
  explicit FrameQueue(FrameSource& source, size_t capacity = 4)
      : source_(source), capacity_(capacity), thread_([this] { read(); }) {}
  ~FrameQueue() {
    {
      const std::lock_guard lock(mutex_);
      stopping_ = true;
    }
    changed_.notify_all();
    thread_.join();
  }

  /// The next item; kEnd after the last, however often it is asked for; rethrows what the source threw.
  SourceItem next() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return !items_.empty() || failure_; });
    if (items_.empty()) std::rethrow_exception(failure_);
    if (items_.front().kind == SourceItem::Kind::kEnd)
      return items_.front();  // stays: the end has nothing behind it
    SourceItem item = std::move(items_.front());
    items_.pop_front();
    large_items_ -= is_large(item);
    changed_.notify_all();
    return item;
  }

 private:
  static constexpr size_t kMostItems = 1024;  // seconds of motion samples while no frame comes

  // Motion samples are small and many: they must not take the frames' places.
  static bool is_large(const SourceItem& item) {
    return item.kind == SourceItem::Kind::kFrame || item.kind == SourceItem::Kind::kSkipped;
  }
  bool is_full() const { return large_items_ >= capacity_ || items_.size() >= kMostItems; }

  void read() {
    constexpr int kLeastUrgent = 19;  // niceness
    setpriority(PRIO_PROCESS, 0,
                kLeastUrgent);  // of this thread alone, as Linux has it; may fail, may not hurt
    try {
      for (bool more = true; more;) {
        SourceItem item = source_.next();
        more = item.kind != SourceItem::Kind::kEnd;
        std::unique_lock lock(mutex_);
        if (item.kind == SourceItem::Kind::kNothingYet && !items_.empty() && !stopping_) continue;
        changed_.wait(lock, [this] { return !is_full() || stopping_; });
        if (stopping_) return;
        large_items_ += is_large(item);
        items_.push_back(std::move(item));
        changed_.notify_all();
      }
    } catch (...) {
      const std::lock_guard lock(mutex_);
      failure_ = std::current_exception();
      changed_.notify_all();
    }
  }

  FrameSource& source_;
  const size_t capacity_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<SourceItem> items_;
  size_t large_items_ = 0;  // of items_
  bool stopping_ = false;
  std::exception_ptr failure_;
  std::thread thread_;  // last: it uses all of the above
};

}  // namespace kt
