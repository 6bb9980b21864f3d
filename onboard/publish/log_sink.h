// Writes the collector's results to an LCM log, as they arise, from a thread of its own.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <chrono>
#include <filesystem>
#include <memory>
#include <thread>

#include "onboard/publish/log_store.h"
#include "onboard/publish/message_sink.h"

namespace kt {

/// Encoding, image compression and disk writes run on the sink's thread behind a bounded queue: a slow disk
/// makes the caller wait, it never loses a message; a full one does, counted (StoragePolicy). Events stand in
/// the log in call order, whatever the timing.
class LogSink final : public MessageSink {
 public:
  using Options = LogStore::Options;
  /// Once `called` is set, by a signal handler perhaps, callers wait for the disk for `patience` in all
  /// and no longer; what still waits for it then is dropped and counted.
  struct End {
    const std::atomic<bool>* called = nullptr;
    std::chrono::milliseconds patience{2500};
  };

  /// Creates the log. Throws kt::Error as LogStore does.
  explicit LogSink(const std::filesystem::path& path) : LogSink(path, Options{}, End{}) {}
  LogSink(const std::filesystem::path& path, const Options& options) : LogSink(path, options, End{}) {}
  LogSink(const std::filesystem::path& path, const Options& options, const End& end);
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
  void on_load(LoadReport load) override { put(load); }
  /// Throws kt::Error where the disk did not take what it was given, in time or at all; not where it was
  /// full.
  void close() override;
  StorageState storage() const override;

 private:
  struct Queue;

  void put(LogItem item);
  void stop();

  std::shared_ptr<Queue> queue_;  ///< shared with the thread, which a dead disk may hold for ever
  std::thread thread_;
};

}  // namespace kt
