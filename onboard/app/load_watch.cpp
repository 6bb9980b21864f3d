// What the clock says goes into load reports, and into nothing else but the effort, which they hold.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/app/load_watch.h"

#include <string>
#include <utility>

namespace kt {
namespace {

constexpr int64_t kFramesPerReport = 30;

double seconds(std::chrono::steady_clock::duration duration) {
  return std::chrono::duration<double>(duration).count();
}

}  // namespace

void LoadWatch::before(const RgbdFrame& frame) {
  const Effort effort = is_live_ ? (may_degrade_ ? control_.effort() : Effort::kFull) : frame.effort;
  if (effort != collector_.effort()) {
    collector_.set_effort(effort);
    report();
  }
  ++frames_by_effort_.at(static_cast<size_t>(effort));
  begun_ = Clock::now();
}

void LoadWatch::after(Clock::time_point arrived) {
  if (!is_live_) return;
  const Clock::time_point now = Clock::now(), last = std::exchange(ended_, now);
  collector_.clock().add("latency", 1e3 * seconds(now - arrived));
  control_.add(frames_.waiting(), seconds(now - begun_), seconds(now - last));
  if (collector_.status().frames % kFramesPerReport == 0) report();
}

void LoadWatch::count_dropped() {
  const int64_t dropped = frames_.dropped();
  collector_.count_skipped_frames(dropped - std::exchange(dropped_, dropped));
}

void LoadWatch::report() {
  LoadReport load;
  load.sequence = reports_++;
  load.timestamp_us = collector_.status().timestamp_us;
  load.frames = collector_.status().frames;
  load.effort = collector_.effort();
  if (is_live_) {
    load.frames_dropped = dropped_;
    load.frames_waiting = frames_.waiting();
    for (size_t i = 0; i < kLoadStages.size(); ++i) {
      const StageTimes times = collector_.clock().recent(std::string(kLoadStages[i]));
      load.stages[i] = {static_cast<float>(times.p50_ms), static_cast<float>(times.p95_ms),
                        static_cast<float>(times.max_ms)};
    }
    collector_.clock().forget_recent();
  }
  sink_.on_load(load);
}

}  // namespace kt
