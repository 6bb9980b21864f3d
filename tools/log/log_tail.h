// Follows a log that is still being written.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <functional>

#include "shared/wire/message_reader.h"

namespace kt {

/// Reads what a log has got since it was looked at last: its session, poses and status messages. Of a folder
/// it follows the log written last, and goes over to the next where a mission begins one.
class LogTail {
 public:
  /// Throws kt::Error where `path` is neither a file nor a folder.
  explicit LogTail(std::filesystem::path path);

  /// Hands the new messages to `take`; of a log seen for the first time its session and its last
  /// few. An event that is still being written is left for the next time. Throws kt::Error where a log
  /// cannot be read or is none.
  void read_new(const std::function<void(const Message&)>& take);

  /// The log followed; empty where the folder holds none yet.
  const std::filesystem::path& log() const { return log_; }
  int64_t log_bytes() const { return size_; }
  /// On the log's disk; -1 where nobody knows.
  int64_t free_bytes() const;

 private:
  void find_log();

  std::filesystem::path path_, log_;
  int64_t read_ = 0;  ///< behind the last whole message
  int64_t size_ = 0;
};

}  // namespace kt
