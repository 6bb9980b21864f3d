// Appends LCM events to a file, each with one writev.
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <sys/file.h>
#include <sys/uio.h>
#include <system_error>
#include <unistd.h>

#include "shared/core/check.h"
#include "shared/wire/codec.h"
#include "shared/wire/event_log.h"
#include "shared/wire/event_log_format.h"
#include "shared/wire/message_layout.h"

namespace kt {
namespace {

std::string reason_of(int error_number) { return std::generic_category().message(error_number); }

bool is_full(int error_number) {
  return error_number == ENOSPC || error_number == EDQUOT || error_number == EFBIG;
}

// So that a new file's name survives a loss of power; where a file system cannot do that, nor can we.
void sync_folder(const std::filesystem::path& file) {
  const std::filesystem::path folder = file.has_parent_path() ? file.parent_path() : ".";
  const int descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return;
  ::fsync(descriptor);
  ::close(descriptor);
}

// Writes every byte of `parts`, in one system call unless the system takes them piecemeal; false with errno
// set.
bool write_all(int file, std::span<iovec> parts) {
  while (!parts.empty()) {
    const ssize_t written = ::writev(file, parts.data(), static_cast<int>(parts.size()));
    if (written < 0) {
      if (errno == EINTR) continue;
      return false;
    }
    auto left = static_cast<size_t>(written);
    while (!parts.empty() && left >= parts.front().iov_len) {
      left -= parts.front().iov_len;
      parts = parts.subspan(1);
    }
    if (parts.empty()) break;
    parts.front().iov_base = static_cast<char*>(parts.front().iov_base) + left;
    parts.front().iov_len -= left;
  }
  return true;
}

}  // namespace

EventLogWriter::EventLogWriter(std::filesystem::path path, bool overwrite) : path_(std::move(path)) {
  constexpr int kFlags = O_WRONLY | O_CREAT | O_CLOEXEC;
  std::error_code ignored;
  file_ = ::open(path_.c_str(), kFlags | O_EXCL, 0666);
  is_new_ = file_ >= 0;
  if (file_ < 0 && errno == EEXIST) {
    if (!overwrite && std::filesystem::is_regular_file(path_, ignored)) {
      throw Error(path_.string() + " exists: name another log file, or pass --overwrite");
    }
    file_ = ::open(path_.c_str(), kFlags, 0666);
  }
  if (file_ < 0) {
    const std::string problem = "cannot create the log " + path_.string() + ": " + reason_of(errno);
    if (is_full(errno)) throw DiskFullError(problem);
    throw Error(problem + "; its folder must exist and be writable");
  }
  // A device may be shared. Where the file system knows no locks, the log is written without one.
  if (std::filesystem::is_regular_file(path_, ignored) && ::flock(file_, LOCK_EX | LOCK_NB) != 0 &&
      errno == EWOULDBLOCK) {
    ::close(file_);
    throw Error("the log " + path_.string() +
                " is being read or written by another program, or is the input itself: name another file");
  }
}

EventLogWriter::~EventLogWriter() {
  if (file_ < 0) return;
  remove_if_unused();
  ::close(file_);
}

int64_t EventLogWriter::event_bytes(std::string_view channel, std::span<const uint8_t> data) {
  return static_cast<int64_t>(kEventHeaderBytes + channel.size() + data.size());
}

void EventLogWriter::write(std::string_view channel, int64_t timestamp_us, std::span<const uint8_t> data) {
  KT_CHECK(file_ >= 0, "the log is closed");
  KT_CHECK(!channel.empty() && channel.size() <= kMaxChannelBytes && data.size() <= kMaxMessageBytes);
  if (!failure_.empty()) throw Error(failure_);
  if (event_count_ == 0 && !is_new_ && ::ftruncate(file_, 0) != 0 && errno != EINVAL) fail(errno);

  uint8_t header[kEventHeaderBytes];
  store_int32(static_cast<int32_t>(kSyncWord), header);
  store_int64(event_count_, header + kEventNumberOffset);
  store_int64(timestamp_us, header + kEventTimeOffset);
  store_int32(static_cast<int32_t>(channel.size()), header + kChannelLengthOffset);
  store_int32(static_cast<int32_t>(data.size()), header + kDataLengthOffset);
  iovec parts[] = {{header, sizeof(header)},
                   {const_cast<char*>(channel.data()), channel.size()},
                   {const_cast<uint8_t*>(data.data()), data.size()}};
  if (!write_all(file_, parts)) fail(errno);
  ++event_count_;
  byte_count_ += event_bytes(channel, data);
}

void EventLogWriter::fail(int error_number) {
  // Cut off a half-written event, and go on where it began; where that cannot be done (a device) readers skip
  // it.
  const bool is_cut = ::ftruncate(file_, byte_count_) == 0 && ::lseek(file_, byte_count_, SEEK_SET) >= 0;
  const std::string problem = "cannot write to the log " + path_.string() + ": " + reason_of(error_number) +
                              "; the " + std::to_string(event_count_) +
                              " events written before are intact. Free space or name a file on another disk";
  if (is_full(error_number) && (is_cut || errno == EINVAL)) throw DiskFullError(problem);
  failure_ = problem;
  throw Error(failure_);
}

void EventLogWriter::remove_if_unused() const {
  if (is_new_ && event_count_ == 0) ::unlink(path_.c_str());
}

int EventLogWriter::sync_error() {
  if (!std::exchange(is_name_synced_, true) && is_new_) sync_folder(path_);
  const int error = ::fdatasync(file_) == 0 ? 0 : errno;
  return error == EINVAL || error == EROFS ? 0 : error;  // a device or a pipe has nothing to sync
}

void EventLogWriter::sync() {
  KT_CHECK(file_ >= 0, "the log is closed");
  if (const int error = sync_error(); error != 0) fail(error);
}

void EventLogWriter::close() {
  if (file_ < 0) return;
  remove_if_unused();
  int error = sync_error();
  const int file = std::exchange(file_, -1);
  if (::close(file) != 0 && errno != EINTR && error == 0) error = errno;
  if (error != 0) {
    throw Error("cannot finish the log " + path_.string() + ": " + reason_of(error) +
                "; its last events may be lost");
  }
}

}  // namespace kt
