// Watches how a mission keeps up with its frames, and reports it.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <chrono>

#include "onboard/app/collector.h"
#include "onboard/app/effort_control.h"
#include "onboard/app/frame_queue.h"
#include "onboard/publish/message_sink.h"

namespace kt {

/// Around every frame that a collector processes: gives it its effort, and publishes load reports, of a live
/// source regularly, of any source where the effort changes. A live source's frames get what EffortControl
/// says; all others what they got when they were recorded.
class LoadWatch {
 public:
  /// All must outlive it. `may_degrade`: else the frames of a live source always get full effort.
  LoadWatch(Collector& collector, const FrameQueue& frames, MessageSink& sink, bool is_live, bool may_degrade)
      : collector_(collector), frames_(frames), sink_(sink), is_live_(is_live), may_degrade_(may_degrade) {}

  void before(const RgbdFrame& frame);
  void after(std::chrono::steady_clock::time_point arrived);
  /// Counts the frames dropped since the call before as skipped ones.
  void count_dropped();

  int64_t dropped() const { return dropped_; }
  /// Frames processed, by Effort.
  const std::array<int64_t, kEfforts>& frames_by_effort() const { return frames_by_effort_; }

 private:
  using Clock = std::chrono::steady_clock;
  void report();

  Collector& collector_;
  const FrameQueue& frames_;
  MessageSink& sink_;
  const bool is_live_, may_degrade_;
  EffortControl control_;
  std::array<int64_t, kEfforts> frames_by_effort_{};
  int64_t dropped_ = 0, reports_ = 0;
  Clock::time_point begun_{}, ended_ = Clock::now();  // the work on the last frame
};

}  // namespace kt
