// Waits for each frame's time.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/source/paced_source.h"

#include <algorithm>
#include <thread>
#include <utility>

namespace kt {
namespace {

// As FrameSource::next() allows: whoever stops the mission is not kept waiting by a long pause.
constexpr std::chrono::milliseconds kLongestWait{100};

}  // namespace

PacedSource::Clock::time_point PacedSource::due(int64_t timestamp_us) {
  if (!start_) {
    start_ = Clock::now();
    first_us_ = timestamp_us;
  }
  return *start_ + std::chrono::microseconds(timestamp_us - first_us_);
}

SourceItem PacedSource::next() {
  if (!held_) {
    SourceItem item = source_->next();
    if (item.kind != SourceItem::Kind::kFrame) return item;
    held_ = std::move(item);
  }
  const Clock::time_point when = due(held_->frame.timestamp_us), until = Clock::now() + kLongestWait;
  std::this_thread::sleep_until(std::min(when, until));
  if (when > until) return {.kind = SourceItem::Kind::kNothingYet};
  return *std::exchange(held_, std::nullopt);
}

}  // namespace kt
