// A bounded queue between the thread that reads frames and the one that processes them.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <optional>
#include <sys/resource.h>
#include <thread>

#include "onboard/source/frame_source.h"
#include "shared/core/recycling.h"

namespace kt {

/// Reads a source ahead on its own thread, with the motion samples among the frames; order and content are
/// the source's, but that kNothingYet is passed on only while nothing else waits, and that frames are
/// numbered from 0 as they are handed out.
///
/// What becomes of frames when the mission is late is decided here and nowhere else:
/// - Of a recorded source at most `capacity` frames and skipped ones are read ahead; then reading waits, and
///   nothing is ever lost. The thread gives way to those that process: on a busy machine images are decoded
///   while the tracker waits, not in its stead.
/// - Of a live source everything is taken at once; where more than `capacity` frames wait, the oldest of them
///   is dropped, and counted.
class FrameQueue {
 public:
  static constexpr size_t kReadAhead = 4, kMostLiveFrames = 30;  // a second of frames

  explicit FrameQueue(FrameSource& source)
      : FrameQueue(source, source.is_live() ? kMostLiveFrames : kReadAhead) {}
  FrameQueue(FrameSource& source, size_t capacity)
      : source_(source), is_live_(source.is_live()), capacity_(capacity) {
    stock(items_, capacity_);
    thread_ = std::thread([this] { read(); });
  }
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
    waiting_ -= is_counted(item);
    if (item.kind == SourceItem::Kind::kFrame) item.frame.sequence = delivered_++;
    changed_.notify_all();
    return item;
  }

  /// Frames dropped so far; 0 where the source is not live.
  int64_t dropped() const {
    const std::lock_guard lock(mutex_);
    return dropped_;
  }
  /// Frames of a live source that wait.
  int waiting() const {
    const std::lock_guard lock(mutex_);
    return is_live_ ? static_cast<int>(waiting_) : 0;
  }

 private:
  static constexpr size_t kMostItems = 1024;  // seconds of motion samples while no frame comes

  // Motion samples are small and many: they must not take the frames' places.
  bool is_counted(const SourceItem& item) const {
    return item.kind == SourceItem::Kind::kFrame || (item.kind == SourceItem::Kind::kSkipped && !is_live_);
  }
  bool is_full() const { return items_.size() >= kMostItems || (!is_live_ && waiting_ >= capacity_); }

  void drop_oldest_frame() {
    const auto is_frame = [](const SourceItem& item) { return item.kind == SourceItem::Kind::kFrame; };
    items_.erase(std::find_if(items_.begin(), items_.end(), is_frame));
    --waiting_;
    ++dropped_;
  }

  void read() {
    constexpr int kLeastUrgent = 19;  // niceness
    // Of this thread alone, as Linux has it; may fail, may not hurt.
    if (!is_live_) setpriority(PRIO_PROCESS, 0, kLeastUrgent);
    try {
      for (bool more = true; more;) {
        SourceItem item = source_.next();
        item.arrived = std::chrono::steady_clock::now();
        more = item.kind != SourceItem::Kind::kEnd;
        std::unique_lock lock(mutex_);
        if (item.kind == SourceItem::Kind::kNothingYet && !items_.empty() && !stopping_) continue;
        changed_.wait(lock, [this] { return !is_full() || stopping_; });
        if (stopping_) return;
        waiting_ += is_counted(item);
        items_.push_back(std::move(item));
        if (is_live_ && waiting_ > capacity_) drop_oldest_frame();
        changed_.notify_all();
      }
    } catch (...) {
      const std::lock_guard lock(mutex_);
      failure_ = std::current_exception();
      changed_.notify_all();
    }
  }

  FrameSource& source_;
  const bool is_live_;
  const size_t capacity_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  RecycledQueue<SourceItem> items_;
  size_t waiting_ = 0;  // items that are counted, of items_
  int64_t delivered_ = 0, dropped_ = 0;
  bool stopping_ = false;
  std::exception_ptr failure_;
  std::thread thread_;
};

}  // namespace kt
