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

#include "shared/core/check.h"
#include "shared/types/session.h"

namespace kt {

/// No room for one more event. Nothing of it was written, and the next may be tried.
class DiskFullError : public Error {
 public:
  using Error::Error;
};

/// Writes a log that lcm-logplayer and every other LCM tool can read.
class EventLogWriter {
 public:
  /// Creates `path`. Throws DiskFullError where there is no room for it, kt::Error where it fails otherwise,
  /// where a file stands there already unless `overwrite`,
  /// and where a reader or another writer has that file open. A file that is to be overwritten stays whole
  /// until the first event is written; one that was created and got no event is removed again.
  explicit EventLogWriter(std::filesystem::path path, bool overwrite = false);
  ~EventLogWriter();
  EventLogWriter(const EventLogWriter&) = delete;
  EventLogWriter& operator=(const EventLogWriter&) = delete;

  /// Appends one event, whole, by one system call. `timestamp_us` is sensor time. Throws DiskFullError where
  /// there is no room for it, kt::Error where the disk is gone, and then at every later call too; the file
  /// ends behind the last whole event.
  void write(std::string_view channel, int64_t timestamp_us, std::span<const uint8_t> data);

  /// Returns once all that was written is on the disk itself; throws kt::Error where that fails.
  void sync();
  /// The same, and no more events. The destructor closes without a word and without waiting for the disk.
  void close();

  int64_t event_count() const { return event_count_; }
  int64_t byte_count() const { return byte_count_; }
  const std::filesystem::path& path() const { return path_; }

  /// What an event takes in a log.
  static int64_t event_bytes(std::string_view channel, std::span<const uint8_t> data);

 private:
  [[noreturn]] void fail(int error_number);
  int sync_error();
  void remove_if_unused() const;

  std::filesystem::path path_;
  int file_ = -1;
  bool is_new_ = false;          ///< created by this writer, not overwritten
  bool is_name_synced_ = false;  ///< a loss of power cannot cost its name any more
  int64_t event_count_ = 0, byte_count_ = 0;
  std::string failure_;  ///< why no more events are taken; empty while all is well
};

/// One event of a log; the views hold until the reader is called again.
struct LogEvent {
  int64_t timestamp_us = 0;  ///< sensor time in our logs, time of receipt in those of lcm-logger
  std::string_view channel;
  std::span<const uint8_t> data;
};

/// Reads a log front to back, be it one file or several, one behind the other. Where the bytes make no sense
/// it looks for the next event that does, and counts. Memory: the largest event. While it lives no
/// EventLogWriter may overwrite the files.
class EventLogReader {
 public:
  /// Throws kt::Error where `path` cannot be read or holds no LCM event at all; an empty file is a log
  /// without events.
  explicit EventLogReader(const std::filesystem::path& path);
  /// Reads these files as one log; needs at least one. Throws as above.
  explicit EventLogReader(std::span<const std::filesystem::path> paths);
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
  struct FileCloser {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  struct File {
    std::unique_ptr<std::FILE, FileCloser> file;
    int64_t begin = 0, end = 0;  ///< in the log
    int64_t position = 0;        ///< of `file`, in the log: to seek only where needed
  };
  void add_file(std::FILE* file, int64_t size);
  void check_is_log(const std::string& name);
  size_t read_at(int64_t position, void* bytes, size_t size);
  std::optional<EventHeader> header_at(int64_t position);
  std::optional<int64_t> find_event(int64_t from, int64_t end);
  bool resume_from(int64_t position);

  std::vector<File> files_;
  int64_t size_ = 0;
  int64_t position_ = 0;        ///< where the next event is expected
  int64_t event_position_ = 0;  ///< of the event last returned
  std::string channel_;
  std::vector<uint8_t> data_;
  LogIntegrity integrity_;
};

}  // namespace kt
