// Renders, stamps and publishes.
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/soak/looped_mission.h"

#include <chrono>
#include <utility>

#include "shared/core/version.h"
#include "shared/synth/mission.h"
#include "shared/wire/channels.h"
#include "shared/wire/frame_codec.h"

namespace kt {

LoopedMission::LoopedMission(const std::string& name, int64_t frames, int downscale) {
  const SyntheticMission mission(name, {.frames = frames, .downscale = downscale});
  session_.program_version = kProgramVersion;
  session_.calibration = mission.calibration();
  for (int64_t i = 0; i < mission.frame_count(); ++i) frames_.push_back(compress(mission.render(i)));
}

MessageBytes LoopedMission::message(int64_t i, double rate_hz) const {
  const auto count = static_cast<int64_t>(frames_.size()), last = count - 1;
  const int64_t phase = count > 1 ? i % (2 * last) : 0;
  CompressedFrame frame = frames_[static_cast<size_t>(phase <= last ? phase : 2 * last - phase)];
  frame.sequence = i;
  frame.timestamp_us = frame.colour_timestamp_us =
      1'000'000 + static_cast<int64_t>(static_cast<double>(i) * 1e6 / rate_hz);
  return encode(frame, i);
}

LoopedPublisher::LoopedPublisher(const LoopedMission& mission, std::shared_ptr<LcmBus> bus, double rate_hz)
    : mission_(mission), bus_(std::move(bus)), rate_hz_(rate_hz), thread_([this] { run(); }) {}

void LoopedPublisher::publish_frame() {
  bus_->publish(channel_of<CompressedFrame>(), mission_.message(published_, rate_hz_));
  ++published_;
}

void LoopedPublisher::run() {
  using Clock = std::chrono::steady_clock;
  bus_->publish(channel_of<SessionHeader>(), encode(mission_.session(), 0));
  const Clock::duration interval =
      std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(1 / rate_hz_));
  for (Clock::time_point due = Clock::now(); !stopping_; due += interval) {
    std::this_thread::sleep_until(due);
    publish_frame();
  }
}

void LoopedPublisher::stop() {
  if (!thread_.joinable()) return;
  stopping_ = true;
  thread_.join();
  std::this_thread::sleep_for(std::chrono::seconds(3));
  publish_frame();
}

}  // namespace kt
