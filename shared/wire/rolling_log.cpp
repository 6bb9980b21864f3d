// Goes from file to file.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/wire/rolling_log.h"

#include <utility>

#include "shared/core/check.h"
#include "shared/io/file.h"
#include "shared/wire/channels.h"
#include "shared/wire/codec.h"
#include "shared/wire/log_parts.h"

namespace kt {

RollingLogWriter::RollingLogWriter(std::filesystem::path path, const Options& options)
    : path_(std::move(path)), options_(options) {
  for (const auto& [number, file] : numbered_files(path_)) {
    if (is_log_part(file, number)) {
      if (options_.overwrite) continue;
      throw Error(file.string() +
                  ", a part of another log, exists: name another log file, or pass --overwrite");
    }
    if (options_.max_file_bytes > 0)
      throw Error(file.string() + " stands where a part of the log would: name another log file");
  }
  file_.emplace(path_, options_.overwrite);
}

void RollingLogWriter::write(std::string_view channel, int64_t timestamp_us, std::span<const uint8_t> data) {
  prepare(EventLogWriter::event_bytes(channel, data));
  file_->write(channel, timestamp_us, data);
  if (!std::exchange(has_begun_, true)) remove_old_parts();
}

// Makes sure that there is a file that takes so many bytes more and begins with the session.
void RollingLogWriter::prepare(int64_t event_bytes) {
  const int64_t events_before = session_ ? 1 : 0;
  if (file_ && options_.max_file_bytes > 0 && file_->event_count() > events_before &&
      file_->byte_count() + event_bytes > options_.max_file_bytes) {
    file_->close();
    finished_bytes_ += file_->byte_count();
    file_.reset();
  }
  if (!file_) open_next_file();
  if (!session_ || file_->event_count() > 0) return;
  file_->write(channel_of<SessionHeader>(), session_->timestamp_us, encode(*session_, part_));
  if (!std::exchange(has_begun_, true)) remove_old_parts();
}

void RollingLogWriter::open_next_file() {
  file_.emplace(log_part_path(path_, part_ + 1));
  ++part_;
}

// Of the log that this one takes the place of. Those of another mission would not be taken for ours, but
// those of the same recording played before would.
void RollingLogWriter::remove_old_parts() {
  if (!options_.overwrite) return;
  for (const auto& [number, part] : numbered_files(path_)) {
    if (is_log_part(part, number)) remove_file(part);
  }
}

void RollingLogWriter::sync() {
  if (file_) file_->sync();
}

void RollingLogWriter::close() {
  if (file_) file_->close();
}

}  // namespace kt
