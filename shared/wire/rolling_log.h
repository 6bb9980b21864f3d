// A log in files of bounded size, each of which can be read by itself.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string_view>

#include "shared/types/session.h"
#include "shared/wire/event_log.h"

namespace kt {

/// Writes NAME.lcm, and where that is full NAME.001.lcm and so on (log_parts.h). Every file begins with the
/// session; numbers of messages are the caller's, and go on.
class RollingLogWriter {
 public:
  struct Options {
    bool overwrite = false;
    /// A file that would grow beyond this is closed and the next one begun; 0 = never. An event that is
    /// larger by itself gets a file of its own.
    int64_t max_file_bytes = 0;
  };

  /// Creates the first file. Throws kt::Error as EventLogWriter does, and where files stand in the way of
  /// later parts: parts of another log, unless they may be overwritten (they are removed behind the first
  /// event then), and files of any other kind where the log may roll.
  RollingLogWriter(std::filesystem::path path, const Options& options);

  /// What every file begins with; to be called first.
  void begin(SessionHeader session) { session_ = std::move(session); }
  /// Appends one event as EventLogWriter::write does. Where there is no room for a new file, or for the
  /// session in it, nothing is written either.
  void write(std::string_view channel, int64_t timestamp_us, std::span<const uint8_t> data);
  /// Writes the session where the log does not have it yet.
  void write_session() { prepare(0); }
  void sync();
  void close();

  /// Bytes of all files.
  int64_t byte_count() const { return finished_bytes_ + (file_ ? file_->byte_count() : 0); }
  const std::filesystem::path& path() const { return path_; }

 private:
  void prepare(int64_t event_bytes);
  void open_next_file();
  void remove_old_parts();

  std::filesystem::path path_;
  Options options_;
  std::optional<SessionHeader> session_;
  std::optional<EventLogWriter> file_;  ///< none where the next one could not be created yet
  int64_t part_ = 0;                    ///< its number, or the last one's
  int64_t finished_bytes_ = 0;          ///< of the files before it
  bool has_begun_ = false;              ///< the first event is written
};

}  // namespace kt
