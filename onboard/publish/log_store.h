// Encodes the collector's results into a log, and decides what still goes there where the disk runs low.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <variant>

#include "onboard/publish/storage_policy.h"
#include "shared/types/rgbd_frame.h"
#include "shared/wire/channels.h"
#include "shared/wire/frame_codec.h"
#include "shared/wire/rolling_log.h"

namespace kt {

/// What is put into a log.
using LogItem = std::variant<SessionHeader, StampedPose, CloudSlice, Keyframe, LoopClosure, MissionStatus,
                             RgbdFrame, MotionSample, LoadReport>;

/// Not for several threads at once.
class LogStore {
 public:
  using Clock = std::chrono::steady_clock;
  struct Options {
    bool overwrite = false;      ///< replace an existing log
    FrameCompression frames{};   ///< of raw frames
    int64_t max_file_bytes = 0;  ///< as RollingLogWriter's
    int64_t reserve_bytes = 0;   ///< as StoragePolicy's
    /// What was written is on the disk itself after so long, at most: what a loss of power may cost.
    std::chrono::milliseconds sync_interval{1000};
    /// Free bytes on the disk of a log; by default those of its file system.
    std::function<int64_t(const std::filesystem::path& log)> free_bytes{};
    /// A slice of more triangles, or three times as many vertices, is logged in parts: LCM's own tools play
    /// no message beyond 256 MiB.
    size_t max_slice_triangles = 1'900'000;
  };

  /// Creates the log. Throws kt::Error as RollingLogWriter does.
  LogStore(const std::filesystem::path& path, const Options& options);

  /// Writes an item, or counts it as not stored where the disk has no room; its number on the channel stays
  /// free then, so that readers see the gap. Throws kt::Error where the disk fails otherwise.
  void store(const LogItem& item);
  /// Counts an item that nobody had the time to store.
  void drop(const LogItem& item);

  /// When sync_if_due() has something to do; Clock::time_point::max() where all is on the disk.
  Clock::time_point next_sync() const { return next_sync_; }
  /// Throws kt::Error where the disk fails.
  void sync_if_due();
  /// Returns once all is on the disk itself.
  void close();

  StorageState state() const;
  const std::filesystem::path& path() const { return writer_.path(); }

 private:
  template <typename T>
  void store_message(const T& message);
  void store_slice(const CloudSlice& slice);
  template <typename T>
  void count_dropped();

  RollingLogWriter writer_;
  const Options options_;
  const bool watches_disk_;  ///< the log is a file, not a device
  StoragePolicy policy_;
  StorageState counts_;
  std::array<int64_t, kChannels.size()> next_sequence_{};
  Clock::time_point next_sync_ = Clock::time_point::max();
};

}  // namespace kt
