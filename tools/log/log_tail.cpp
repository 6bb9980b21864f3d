// Opens the log anew each time, and goes on where it stopped.
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/log/log_tail.h"

#include <algorithm>
#include <system_error>

#include "shared/core/check.h"

namespace kt {
namespace {

namespace fs = std::filesystem;

constexpr int64_t kFirstLook = 8 << 20, kLongerLook = 8;

}  // namespace

LogTail::LogTail(fs::path path) : path_(std::move(path)) {
  std::error_code ignored;
  if (!fs::exists(path_, ignored))
    throw Error(path_.string() + " does not exist: name a log, or the folder of logs");
}

void LogTail::find_log() {
  std::error_code error;
  if (!fs::is_directory(path_, error)) {
    log_ = path_;
    return;
  }
  fs::path newest;
  fs::file_time_type newest_time;
  for (fs::directory_iterator entry(path_, error), end; !error && entry != end; entry.increment(error)) {
    if (entry->path().extension() != ".lcm") continue;
    const fs::file_time_type time = entry->last_write_time(error);
    if (!error && (newest.empty() || time > newest_time)) {
      newest = entry->path();
      newest_time = time;
    }
    error.clear();
  }
  if (newest == log_) return;
  log_ = newest;
  read_ = 0;
}

void LogTail::read_new(const std::function<void(const Message&)>& take) {
  find_log();
  std::error_code error;
  const auto size = log_.empty() ? 0 : static_cast<int64_t>(fs::file_size(log_, error));
  if (error) throw Error("cannot read the log " + log_.string() + ": " + error.message());
  if (size < read_) read_ = 0;  // written anew
  const bool is_new = read_ == 0;
  size_ = size;
  // An empty one is not opened: its writer may be about to lock it.
  if (size == 0 || size == read_) return;
  MessageReader reader(log_);
  reader.skip<CloudSlice>();
  reader.skip<Keyframe>();
  reader.skip<LoopClosure>();
  reader.skip<CompressedFrame>();
  reader.skip<MotionSample>();
  const auto take_next = [&] {
    const std::optional<Message> message = reader.next();
    if (!message) return false;
    take(*message);
    read_ = reader.position();
    return true;
  };
  if (is_new) take_next();  // the session
  const int64_t start = read_;
  // Its end first; farther back only where that holds nothing but one large message.
  for (int64_t look = is_new ? kFirstLook : size; read_ == start; look *= kLongerLook) {
    reader.seek(std::max(start, size - look));
    while (take_next()) {
    }
    if (look >= size) break;
  }
}

int64_t LogTail::free_bytes() const {
  std::error_code error;
  const fs::space_info space = fs::space(log_.empty() ? path_ : log_, error);
  return error ? -1 : static_cast<int64_t>(space.available);
}

}  // namespace kt
