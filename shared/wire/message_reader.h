// Reads the typed messages of a log: events, checksums, decoding and sequence numbers together.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <optional>
#include <set>
#include <string>

#include "shared/wire/channels.h"
#include "shared/wire/event_log.h"
#include "shared/wire/log_parts.h"

namespace kt {

class MessageReader {
 public:
  /// Reads the log `path` and the parts behind it (log_parts) as one. Throws kt::Error as EventLogReader
  /// does.
  explicit MessageReader(const std::filesystem::path& path) : MessageReader(log_parts(path)) {}
  explicit MessageReader(const LogParts& parts);
  explicit MessageReader(EventLogReader events);

  /// Leaves out the messages of type T from now on: checked and counted, but neither decoded nor returned.
  template <typename T>
  void skip() {
    skipped_[message_index<T>()] = true;
  }

  /// The next intact message, or nothing at the end. Damaged and unknown events are counted and passed over;
  /// a session that is repeated, by a later part or over LCM, is counted only.
  std::optional<Message> next();

  /// As EventLogReader's: where the message last returned begins, and to go on elsewhere.
  int64_t event_position() const { return events_.event_position(); }
  void seek(int64_t position) { events_.seek(position); }

  /// Events, damage and gaps so far. Whether the final slice is missing is not told where slices are skipped.
  LogIntegrity integrity() const;

  /// What one channel holds so far.
  struct ChannelCount {
    int64_t messages = 0, bytes = 0;    ///< intact ones, skipped types included
    int64_t damaged = 0;                ///< events that were no message of the channel's type
    int64_t missing = 0;                ///< gaps in the sequence numbers
    int64_t first_us = 0, last_us = 0;  ///< stamps of the first and last message
  };
  /// In the order of kChannels.
  const std::array<ChannelCount, kChannels.size()>& channels() const { return channels_; }

  /// Bytes read so far, and in all: for progress.
  int64_t position() const { return events_.position(); }
  int64_t size() const { return events_.size(); }
  /// Files that the log consists of.
  int64_t parts() const { return parts_; }

 private:
  bool repeats_session(std::span<const uint8_t> bytes);

  EventLogReader events_;
  int64_t parts_ = 1, missing_parts_ = 0;
  std::set<uint64_t> sessions_;  ///< digests of their contents
  int64_t unknown_events_ = 0;
  bool final_slice_seen_ = false;
  std::array<bool, kChannels.size()> skipped_{};
  std::array<int64_t, kChannels.size()> next_sequence_{};
  std::array<ChannelCount, kChannels.size()> channels_{};
};

/// Throws kt::Error naming the log `name` where its format is newer than this program: for whoever reads a
/// session event.
void check_format_version(const SessionHeader& header, const std::string& name);

}  // namespace kt
