// Reads LCM events and finds the way back to them after damage.
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cerrno>
#include <cstring>
#include <sys/file.h>
#include <sys/types.h>
#include <system_error>

#include "shared/core/check.h"
#include "shared/wire/codec.h"
#include "shared/wire/event_log.h"
#include "shared/wire/event_log_format.h"
#include "shared/wire/message_layout.h"

namespace kt {
namespace {

constexpr uint8_t kSyncBytes[] = {kSyncWord >> 24, kSyncWord >> 16 & 0xff, kSyncWord >> 8 & 0xff,
                                  kSyncWord & 0xff};
// An LCM log whose first events are all damaged this far is not told from any other file.
constexpr int64_t kFirstEventWithin = int64_t{64} << 20;
constexpr size_t kScanBytes = size_t{1} << 16;

std::string reason(int error_number) { return std::generic_category().message(error_number); }

}  // namespace

EventLogReader::EventLogReader(const std::filesystem::path& path) : EventLogReader({&path, 1}) {}

EventLogReader::EventLogReader(std::span<const std::filesystem::path> paths) {
  KT_CHECK(!paths.empty());
  for (const std::filesystem::path& path : paths) {
    std::error_code error;
    const std::filesystem::file_status status = std::filesystem::status(path, error);
    if (!std::filesystem::exists(status)) throw Error("the log " + path.string() + " does not exist");
    if (!std::filesystem::is_regular_file(status))
      throw Error(path.string() + " is not a file: name an LCM log");
    const auto size = std::filesystem::file_size(path, error);
    std::FILE* file = std::fopen(path.c_str(), "rb");
    if (file == nullptr || error) {
      throw Error("cannot read the log " + path.string() + ": " + (error ? error.message() : reason(errno)));
    }
    // A log that is still being written may be read; the lock only keeps writers from overwriting it
    // meanwhile.
    [[maybe_unused]] const int ignored = ::flock(::fileno(file), LOCK_SH | LOCK_NB);
    add_file(file, static_cast<int64_t>(size));
  }
  check_is_log(paths.front().string());
}

EventLogReader::EventLogReader(std::span<const uint8_t> bytes, const std::string& name) {
  // Opened for reading only, so the bytes stay as they are.
  std::FILE* file =
      bytes.empty() ? nullptr : ::fmemopen(const_cast<uint8_t*>(bytes.data()), bytes.size(), "rb");
  KT_CHECK(bytes.empty() || file != nullptr);
  if (file != nullptr) add_file(file, static_cast<int64_t>(bytes.size()));
  check_is_log(name);
}

void EventLogReader::add_file(std::FILE* file, int64_t size) {
  files_.emplace_back().file.reset(file);
  files_.back().begin = files_.back().position = size_;
  files_.back().end = size_ += size;
}

void EventLogReader::check_is_log(const std::string& name) {
  if (size_ == 0 || header_at(0)) return;
  uint8_t start[sizeof(kSyncBytes)];
  const size_t got = read_at(0, start, sizeof(start));
  const bool begins_like_a_log = got > 0 && std::equal(start, start + got, kSyncBytes);
  if (!begins_like_a_log && !find_event(0, std::min(size_, kFirstEventWithin))) {
    throw Error(name + " is not an LCM log: no event was found in it");
  }
}

size_t EventLogReader::read_at(int64_t position, void* bytes, size_t size) {
  size_t done = 0;
  for (File& file : files_) {
    const int64_t at = position + static_cast<int64_t>(done);
    if (done == size || at >= file.end || at < file.begin) continue;
    const auto wanted =
        static_cast<size_t>(std::min<int64_t>(static_cast<int64_t>(size - done), file.end - at));
    if (at != file.position && ::fseeko(file.file.get(), static_cast<off_t>(at - file.begin), SEEK_SET) != 0)
      break;
    const size_t got = std::fread(static_cast<char*>(bytes) + done, 1, wanted, file.file.get());
    file.position = at + static_cast<int64_t>(got);
    done += got;
    if (got != wanted) break;
  }
  return done;
}

std::optional<EventLogReader::EventHeader> EventLogReader::header_at(int64_t position) {
  uint8_t bytes[kEventHeaderBytes];
  if (size_ - position < static_cast<int64_t>(sizeof(bytes)) ||
      read_at(position, bytes, sizeof(bytes)) != sizeof(bytes)) {
    return {};
  }
  if (!std::equal(std::begin(kSyncBytes), std::end(kSyncBytes), bytes)) return {};
  const EventHeader header{load_int64(bytes + kEventTimeOffset), load_int32(bytes + kChannelLengthOffset),
                           load_int32(bytes + kDataLengthOffset)};
  if (header.channel_bytes < 1 || header.channel_bytes > static_cast<int32_t>(kMaxChannelBytes)) return {};
  if (header.data_bytes < 0 || header.data_bytes > kMaxMessageBytes) return {};
  const int64_t left = size_ - position - static_cast<int64_t>(sizeof(bytes));
  if (int64_t{header.channel_bytes} + header.data_bytes > left) return {};
  channel_.resize(static_cast<size_t>(header.channel_bytes));
  if (read_at(position + static_cast<int64_t>(sizeof(bytes)), channel_.data(), channel_.size()) !=
      channel_.size())
    return {};
  const bool printable =
      std::all_of(channel_.begin(), channel_.end(), [](char c) { return c > ' ' && c < 127; });
  return printable ? std::optional(header) : std::nullopt;
}

std::optional<int64_t> EventLogReader::find_event(int64_t from, int64_t end) {
  std::vector<uint8_t> block(kScanBytes);
  for (int64_t position = from; position < end;) {
    const size_t got = read_at(position, block.data(), block.size());
    if (got < kEventHeaderBytes) break;
    const auto stop = block.begin() + static_cast<std::ptrdiff_t>(got);
    for (auto at = block.begin();
         (at = std::search(at, stop, std::begin(kSyncBytes), std::end(kSyncBytes))) != stop; ++at) {
      if (const int64_t found = position + (at - block.begin()); header_at(found)) return found;
    }
    position += static_cast<int64_t>(got - (sizeof(kSyncBytes) - 1));  // a sync word may straddle two blocks
  }
  return {};
}

// Takes up the reading at the first event from `position` on; false where there is none.
bool EventLogReader::resume_from(int64_t position) {
  if (const std::optional<int64_t> found = find_event(position, size_)) {
    integrity_.skipped_bytes += *found - position_;
    position_ = *found;
    return true;
  }
  uint8_t tail[sizeof(kSyncBytes)] = {};
  const size_t got = read_at(position_, tail, sizeof(tail));
  if (got > 0 && std::equal(tail, tail + got, kSyncBytes)) {
    integrity_.truncated = true;
  } else {
    integrity_.skipped_bytes += size_ - position_;
  }
  position_ = size_;
  return false;
}

std::optional<LogEvent> EventLogReader::next() {
  while (position_ < size_) {
    const std::optional<EventHeader> header = header_at(position_);
    if (!header) {
      if (!resume_from(position_ + 1)) break;
      continue;
    }
    const int64_t data_position = position_ + static_cast<int64_t>(kEventHeaderBytes) + header->channel_bytes;
    data_.resize(static_cast<size_t>(header->data_bytes));
    if (read_at(data_position, data_.data(), data_.size()) != data_.size()) {
      integrity_.truncated = true;  // the file shrank, or the disk fails
      position_ = size_;
      break;
    }
    event_position_ = position_;
    position_ = data_position + header->data_bytes;
    ++integrity_.events;
    return LogEvent{header->timestamp_us, channel_, data_};
  }
  return {};
}

void EventLogReader::seek(int64_t position) {
  KT_CHECK(position >= 0);
  position_ = std::min(position, size_);
}

bool EventLogReader::is_followed_by_event() { return position_ == size_ || header_at(position_); }

void EventLogReader::reject() {
  KT_CHECK(integrity_.events > 0, "no event to reject");
  --integrity_.events;
  ++integrity_.damaged_events;
  if (is_followed_by_event()) return;
  // The next event begins inside this one, or this one's neighbour is damaged too: either way the search
  // finds the next.
  if (const std::optional<int64_t> found = find_event(event_position_ + 1, size_)) {
    integrity_.skipped_bytes += std::max<int64_t>(0, *found - position_);
    position_ = *found;
  }
}

}  // namespace kt
