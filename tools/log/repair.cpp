// Copies what is whole.
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/log/repair.h"

#include <algorithm>
#include <cerrno>
#include <fcntl.h>
#include <string>
#include <sys/file.h>
#include <system_error>
#include <unistd.h>
#include <vector>

#include "shared/core/check.h"
#include "shared/io/file.h"
#include "shared/wire/channels.h"
#include "shared/wire/codec.h"
#include "shared/wire/event_log.h"
#include "shared/wire/log_parts.h"

namespace kt {
namespace {

namespace fs = std::filesystem;

// Keeps writers away while it lives.
class Lock {
 public:
  explicit Lock(const fs::path& log) : file_(::open(log.c_str(), O_RDONLY | O_CLOEXEC)) {
    if (file_ >= 0 && ::flock(file_, LOCK_SH | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
      ::close(file_);
      throw Error("the log " + log.string() + " is still being written: stop its mission first");
    }
  }
  ~Lock() {
    if (file_ >= 0) ::close(file_);
  }
  Lock(const Lock&) = delete;
  Lock& operator=(const Lock&) = delete;

 private:
  int file_;
};

struct OwnedEvent {
  int64_t timestamp_us;
  std::string channel;
  std::vector<uint8_t> data;
};

// Nothing vouches for a foreign event but another one behind it.
bool is_intact(EventLogReader& reader, const OwnedEvent& event) {
  const bool is_ours = std::find(kChannels.begin(), kChannels.end(), event.channel) != kChannels.end();
  return is_ours ? has_valid_checksum(event.data) : reader.is_followed_by_event();
}

void add(LogIntegrity& sum, const LogIntegrity& more) {
  sum.events += more.events;
  sum.damaged_events += more.damaged_events;
  sum.skipped_bytes += more.skipped_bytes;
  sum.truncated |= more.truncated;
}

// False where there is none.
bool copy_intact_events(const fs::path& from, const fs::path& to, RepairReport& report) {
  EventLogReader reader(from);
  EventLogWriter writer(to, /*overwrite=*/true);
  int64_t lost_bytes = reader.size();
  while (const std::optional<LogEvent> next = reader.next()) {
    const OwnedEvent event{
        next->timestamp_us, std::string(next->channel), {next->data.begin(), next->data.end()}};
    if (!is_intact(reader, event)) {
      reader.reject();
      continue;
    }
    writer.write(event.channel, event.timestamp_us, event.data);
    lost_bytes -= EventLogWriter::event_bytes(event.channel, event.data);
  }
  writer.close();
  add(report.found, reader.integrity());
  if (reader.integrity().truncated) report.cut_bytes += lost_bytes - reader.integrity().skipped_bytes;
  return writer.event_count() > 0;
}

void refuse_existing(const fs::path& path, const RepairOptions& options, const fs::path& log) {
  std::error_code ignored;
  const fs::file_status status = fs::status(path, ignored);
  if (!fs::exists(status)) return;
  if (!fs::is_regular_file(status)) throw Error(path.string() + " is not a file: name another output");
  if (options.in_place) return;
  if (fs::equivalent(path, log, ignored))
    throw Error(path.string() + " is the log itself: name another output, or pass --in-place");
  if (!options.overwrite) throw Error(path.string() + " exists: name another output, or pass --overwrite");
}

// False where nothing in it is intact: then nothing is written.
bool repair_file(const fs::path& from, const fs::path& to, RepairReport& report) {
  const fs::path whole = to.string() + ".repairing";
  std::error_code error;
  try {
    if (!copy_intact_events(from, whole, report)) return false;
    rename_file(whole, to);
    return true;
  } catch (...) {
    if (fs::is_regular_file(fs::symlink_status(whole, error))) fs::remove(whole, error);
    throw;
  }
}

fs::path output_of(const fs::path& log, const RepairOptions& options) {
  if (options.in_place) return fs::exists(log) ? fs::canonical(log) : log;  // not what may be a link to it
  if (!options.output.empty()) return options.output;
  fs::path path = log;
  return path.replace_filename(log.stem().string() + ".repaired" + log.extension().string());
}

}  // namespace

RepairReport repair_log(const fs::path& log, const RepairOptions& options) {
  if (options.in_place && !options.output.empty()) throw Error("--in-place and an output exclude each other");
  const std::vector<fs::path> parts = log_parts(log).paths;
  RepairReport report{output_of(log, options)};
  // The number of a part stands in its name and in its session: it stays.
  const auto target = [&](size_t i) {
    if (options.in_place) return i == 0 ? report.output : fs::canonical(parts[i]);
    const std::string number = i == 0 ? "" : parts[i].stem().extension().string();
    fs::path path = report.output;
    return path.replace_filename(path.stem().string() + number + path.extension().string());
  };
  for (size_t i = 0; i < parts.size(); ++i) refuse_existing(target(i), options, parts[i]);
  for (size_t i = 0; i < parts.size(); ++i) {
    const Lock lock(parts[i]);
    if (repair_file(parts[i], target(i), report)) {
      ++report.files;
    } else if (i == 0) {
      throw Error(parts[i].string() + " holds no intact event");
    }
  }
  return report;
}

std::string repair_text(const RepairReport& report) {
  const LogIntegrity& found = report.found;
  std::string text = report.output.string() + ": " + std::to_string(found.events) + " events kept";
  if (report.files > 1) text += " in " + std::to_string(report.files) + " files";
  if (found.damaged_events + found.skipped_bytes + report.cut_bytes == 0)
    return text + ", nothing was damaged";
  if (found.damaged_events > 0)
    text += ", " + std::to_string(found.damaged_events) + " damaged events dropped";
  if (found.skipped_bytes > 0)
    text += ", " + std::to_string(found.skipped_bytes) + " bytes between events dropped";
  if (report.cut_bytes > 0)
    text += ", " + std::to_string(report.cut_bytes) + " bytes of an event that is cut off dropped";
  return text;
}

}  // namespace kt
