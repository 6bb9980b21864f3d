// Writes the collector's results to an LCM log, as they arise, from a thread of its own.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <condition_variable>
#include <deque>
#include <exception>
#include <filesystem>
#include <mutex>
#include <thread>
#include <variant>

#include "onboard/publish/message_sink.h"
#include "shared/wire/channels.h"
#include "shared/wire/event_log.h"
#include "shared/wire/frame_codec.h"

namespace kt {

/// Encoding, image compression and disk writes run on the sink's thread behind a bounded queue: a slow disk
/// makes the caller wait, it never loses a message. Events stand in the log in call order, whatever the
/// timing.
class LogSink final : public MessageSink {
 public:
  struct Options {
    bool overwrite = false;     ///< replace an existing log
    FrameCompression frames{};  ///< of raw frames
    /// A slice of more triangles, or three times as many vertices, is logged in parts: LCM's own tools play
    /// no message beyond 256 MiB.
    size_t max_slice_triangles = 1'900'000;
  };

  /// Creates the log. Throws kt::Error as EventLogWriter does.
  explicit LogSink(const std::filesystem::path& path) : LogSink(path, Options{}) {}
  LogSink(const std::filesystem::path& path, const Options& options);
  /// Stores what is queued; an error is dropped, so call close() first.
  ~LogSink() override;

  void on_session(SessionHeader session) override { put(std::move(session)); }
  void on_pose(StampedPose pose) override { put(std::move(pose)); }
  void on_slice(CloudSlice slice) override { put(std::move(slice)); }
  void on_keyframe(Keyframe keyframe) override { put(std::move(keyframe)); }
  void on_loop_closure(LoopClosure loop) override { put(std::move(loop)); }
  void on_status(MissionStatus status) override { put(std::move(status)); }
  void on_raw_frame(RgbdFrame frame) override { put(std::move(frame)); }
  void on_motion_sample(MotionSample sample) override { put(std::move(sample)); }
  void close() override;

 private:
  using Item = std::variant<SessionHeader, StampedPose, CloudSlice, Keyframe, LoopClosure, MissionStatus,
                            RgbdFrame, MotionSample>;

  void put(Item item);
  void run();
  void store(const Item& item);
  void stop();

  EventLogWriter writer_;
  FrameCompression compression_;
  size_t max_slice_triangles_;
  std::array<int64_t, kChannels.size()> next_sequence_{};  ///< used by the thread alone

  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Item> queue_;
  bool stopping_ = false;
  std::exception_ptr failure_;
  std::thread thread_;
};

}  // namespace kt
