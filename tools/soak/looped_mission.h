// A synthetic mission that goes to and fro for ever, on an LCM bus at the pace of its camera.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "shared/types/session.h"
#include "shared/wire/codec.h"
#include "shared/wire/compressed_frame.h"
#include "shared/wire/lcm_bus.h"

namespace kt {

/// The frames of a synthetic mission, rendered once and kept compressed: 0, 1, ..., n - 1, n - 2, ..., 1, 0,
/// 1, ..., so that the camera never jumps.
class LoopedMission {
 public:
  LoopedMission(const std::string& name, int64_t frames, int downscale);

  const SessionHeader& session() const { return session_; }
  /// The LCM message of the i-th frame of the endless mission, stamped at `rate_hz`.
  MessageBytes message(int64_t i, double rate_hz) const;

 private:
  SessionHeader session_;
  std::vector<CompressedFrame> frames_;
};

/// Publishes it from a thread of its own, at `rate_hz` by the wall clock, session first, until it is stopped.
class LoopedPublisher {
 public:
  LoopedPublisher(const LoopedMission& mission, std::shared_ptr<LcmBus> bus, double rate_hz);
  ~LoopedPublisher() { stop(); }

  int64_t published() const { return published_; }
  /// Publishes one frame more after a pause, so that the listener knows of all that it missed before.
  void stop();

 private:
  void run();
  void publish_frame();

  const LoopedMission& mission_;
  std::shared_ptr<LcmBus> bus_;
  const double rate_hz_;
  std::atomic<bool> stopping_{false};
  std::atomic<int64_t> published_{0};
  std::thread thread_;
};

}  // namespace kt
