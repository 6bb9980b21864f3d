// LCM log files: written event by event so that a crash costs at most the last one, read so that damage costs
// no more.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "shared/types/session.h"

namespace kt {

/// Writes a log that lcm-logplayer and every other LCM tool can read.
class EventLogWriter {
 public:
  /// Creates `path`. Throws kt::Error where that fails, where a file stands there already unless `overwrite`,
  /// and where a reader or another writer has that file open. A file that is to be overwritten stays whole
  /// until the first event is written; one that was created and got no event is removed again.
  explicit EventLogWriter(std::filesystem::path path, bool overwrite = false);
  ~EventLogWriter();
  EventLogWriter(const EventLogWriter&) = delete;
  EventLogWriter& operator=(const EventLogWriter&) = delete;

  /// Appends one event, whole, by one system call. `timestamp_us` is sensor time. Throws kt::Error where the
  /// disk is full or gone: the file then ends behind the last whole event, and so does every later call.
  void write(std::string_view channel, int64_t timestamp_us, std::span<const uint8_t> data);

  /// Returns once the log is on the disk itself; throws kt::Error where that fails. The destructor closes
  /// without a word and without waiting for the disk.
  void close();

  int64_t event_count() const { return event_count_; }
  int64_t byte_count() const { return byte_count_; }

 private:
  [[noreturn]] void fail(int error_number);
  void remove_if_unused() const;

  std::filesystem::path path_;
  int file_ = -1;
  bool is_new_ = false;  ///< created by this writer, not overwritten
  int64_t event_count_ = 0, byte_count_ = 0;
  std::string failure_;  ///< why no more events are taken; empty while all is well
};

/// One event of a log; the views hold until the reader is called again.
struct LogEvent {
  int64_t timestamp_us = 0;  ///< sensor time in our logs, time of receipt in those of lcm-logger
  std::string_view channel;
  std::span<const uint8_t> data;
};

/// Reads a log front to back. Where the bytes make no sense it looks for the next event that does, and
/// counts. Memory: the largest event. While it lives no EventLogWriter may overwrite the file.
class EventLogReader {
 public:
  /// Throws kt::Error where `path` cannot be read or holds no LCM event at all; an empty file is a log
  /// without events.
  explicit EventLogReader(const std::filesystem::path& path);
  /// Reads a log in memory; `bytes` must outlive the reader. Throws as above; `name` stands in the message.
  EventLogReader(std::span<const uint8_t> bytes, const std::string& name);

  /// The next event, or nothing at the end. Never throws on damage.
  std::optional<LogEvent> next();

  /// Whether the event last returned ends where the log does or another event begins.
  bool is_followed_by_event();
  /// Says that the event last returned proved damaged: counts it so, and where its length may be what is
  /// damaged (no event begins behind it) resumes the search inside it.
  void reject();

  /// Where the event last returned begins in the log, for seek().
  int64_t event_position() const { return event_position_; }
  /// Goes on reading at `position`; what lies between is not looked at.
  void seek(int64_t position);

  /// Counts so far. unknown_events and missing_messages are for whoever knows the channels: here 0.
  const LogIntegrity& integrity() const { return integrity_; }
  /// Bytes read so far, and in all: for progress.
  int64_t position() const { return position_; }
  int64_t size() const { return size_; }

 private:
  struct EventHeader {
    int64_t timestamp_us = 0;
    int32_t channel_bytes = 0, data_bytes = 0;
  };
  void open(std::FILE* file, int64_t size, const std::string& name);
  size_t read_at(int64_t position, void* bytes, size_t size);
  std::optional<EventHeader> header_at(int64_t position);
  std::optional<int64_t> find_event(int64_t from, int64_t end);
  bool resume_from(int64_t position);

  struct FileCloser {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  std::unique_ptr<std::FILE, FileCloser> file_;
  int64_t size_ = 0;
  int64_t file_position_ = 0;   ///< of file_, to seek only where needed
  int64_t position_ = 0;        ///< where the next event is expected
  int64_t event_position_ = 0;  ///< of the event last returned
  std::string channel_;
  std::vector<uint8_t> data_;
  LogIntegrity integrity_;
};

}  // namespace kt
