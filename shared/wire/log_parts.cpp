// Finds the parts of a log by name, and checks them by the session that they begin with.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/wire/log_parts.h"

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <optional>
#include <set>
#include <string>
#include <system_error>

#include "shared/core/check.h"
#include "shared/wire/channels.h"
#include "shared/wire/codec.h"
#include "shared/wire/event_log.h"

namespace kt {
namespace {

namespace fs = std::filesystem;

constexpr size_t kLeastDigits = 3;

struct PartSession {
  int64_t number = 0;
  std::vector<uint8_t> content;
};

// What a file begins with, where that is an intact session event.
std::optional<PartSession> session_of(const fs::path& path) {
  try {
    EventLogReader reader(path);
    const std::optional<LogEvent> event = reader.next();
    if (!event || event->channel != channel_of<SessionHeader>() || !has_valid_checksum(event->data))
      return {};
    return PartSession{stamp_of(event->data).sequence, content_of(event->data)};
  } catch (const Error&) {
    return {};
  }
}

// The number in front of the extension: 2 of NAME.002.lcm.
std::optional<int64_t> number_in(const fs::path& path) {
  const std::string digits = path.stem().extension().string();  // ".002"
  int64_t number = 0;
  if (digits.size() <= kLeastDigits) return {};
  const auto [end, error] = std::from_chars(digits.data() + 1, digits.data() + digits.size(), number);
  if (error != std::errc() || end != digits.data() + digits.size() || number <= 0) return {};
  return number;
}

}  // namespace

fs::path log_part_path(const fs::path& first, int64_t number) {
  if (number == 0) return first;
  char digits[32];
  std::snprintf(digits, sizeof digits, ".%03lld", static_cast<long long>(number));
  fs::path path = first;
  return path.replace_filename(first.stem().string() + digits + first.extension().string());
}

LogParts log_parts(const fs::path& path) {
  LogParts parts{{path}};
  const std::optional<PartSession> session = session_of(path);
  fs::path first = path;
  int64_t last = 0;
  if (session && session->number > 0 && number_in(path) == session->number) {
    first.replace_filename(path.stem().stem().string() + path.extension().string());
    last = session->number;
  }
  for (const auto& [number, file] : numbered_files(first)) {
    if (number <= last) continue;
    const std::optional<PartSession> its = session_of(file);
    const bool is_foreign = its && (its->number != number || (session && its->content != session->content));
    if (is_foreign) continue;
    parts.missing += number - last - 1;
    parts.paths.push_back(file);
    last = number;
  }
  return parts;
}

std::vector<fs::path> without_later_parts(const std::vector<fs::path>& paths) {
  std::set<fs::path> later;
  for (const fs::path& path : paths) {
    const std::vector<fs::path> parts = log_parts(path).paths;
    for (size_t i = 1; i < parts.size(); ++i) later.insert(fs::absolute(parts[i]).lexically_normal());
  }
  std::vector<fs::path> logs;
  for (const fs::path& path : paths)
    if (!later.contains(fs::absolute(path).lexically_normal())) logs.push_back(path);
  return logs;
}

std::map<int64_t, fs::path> numbered_files(const fs::path& first) {
  std::map<int64_t, fs::path> files;
  const fs::path folder = first.has_parent_path() ? first.parent_path() : fs::path(".");
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    const std::optional<int64_t> number = number_in(entry->path());
    if (!number || !entry->is_regular_file(error)) continue;
    const fs::path expected = log_part_path(first, *number);
    if (entry->path().filename() == expected.filename()) files.emplace(*number, expected);
  }
  return files;
}

bool is_log_part(const fs::path& path, int64_t number) {
  const std::optional<PartSession> session = session_of(path);
  return session && session->number == number;
}

}  // namespace kt
