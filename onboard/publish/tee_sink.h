// One mission to two places: all of it to the log, and its results to whoever listens at the moment.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <utility>

#include "onboard/publish/message_sink.h"

namespace kt {

/// Hands everything to `log`, then all but raw frames and motion samples, the mission's input, to `live`.
/// Both must outlive it.
class TeeSink final : public MessageSink {
 public:
  TeeSink(MessageSink& log, MessageSink& live) : log_(log), live_(live) {}

  void on_session(SessionHeader session) override {
    log_.on_session(session);
    live_.on_session(std::move(session));
  }
  void on_pose(StampedPose pose) override {
    log_.on_pose(pose);
    live_.on_pose(std::move(pose));
  }
  void on_slice(CloudSlice slice) override {
    log_.on_slice(slice);
    live_.on_slice(std::move(slice));
  }
  void on_keyframe(Keyframe keyframe) override {
    log_.on_keyframe(keyframe);
    live_.on_keyframe(std::move(keyframe));
  }
  void on_loop_closure(LoopClosure loop) override {
    log_.on_loop_closure(loop);
    live_.on_loop_closure(std::move(loop));
  }
  void on_status(MissionStatus status) override {
    log_.on_status(status);
    live_.on_status(std::move(status));
  }
  void on_raw_frame(RgbdFrame frame) override { log_.on_raw_frame(std::move(frame)); }
  void on_motion_sample(MotionSample sample) override { log_.on_motion_sample(std::move(sample)); }
  /// The log first: it must be whole even where `live` takes its time.
  void close() override {
    log_.close();
    live_.close();
  }

 private:
  MessageSink& log_;
  MessageSink& live_;
};

}  // namespace kt
