// Line and number parsing by std::from_chars.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/io/text_lines.h"

#include <charconv>
#include <cmath>
#include <system_error>

#include "shared/core/check.h"
#include "shared/types/timestamp.h"

namespace kt {
namespace {

constexpr int64_t kMicroseconds = 1'000'000;
constexpr int64_t kMaxSeconds = kMaxTimestamp_us / kMicroseconds;

template <typename T>
std::optional<T> parse_whole(std::string_view text) {
  if (text.starts_with('+')) text.remove_prefix(1);
  T value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

bool is_digit(char c) { return c >= '0' && c <= '9'; }

}  // namespace

std::optional<double> parse_number(std::string_view text) { return parse_whole<double>(text); }
std::optional<int64_t> parse_integer(std::string_view text) { return parse_whole<int64_t>(text); }

std::optional<int64_t> parse_stamp_us(std::string_view text) {
  // Digits are summed as integers: a double holds 1305031102.160407 only to 0.2 us.
  std::string_view rest = text;
  const bool negative = rest.starts_with('-');
  if (negative) rest.remove_prefix(1);
  int64_t seconds = 0;
  size_t digits = 0;
  for (; digits < rest.size() && is_digit(rest[digits]); ++digits) {
    seconds = seconds * 10 + (rest[digits] - '0');
    if (seconds > kMaxSeconds) return std::nullopt;
  }
  rest.remove_prefix(digits);
  int64_t fraction_us = 0;
  if (rest.starts_with('.')) {
    rest.remove_prefix(1);
    int64_t unit = kMicroseconds / 10;
    size_t decimals = 0;
    for (; decimals < rest.size() && is_digit(rest[decimals]); ++decimals, unit /= 10) {
      const int digit = rest[decimals] - '0';
      fraction_us += digit * unit;
      if (decimals == 6 && digit >= 5) ++fraction_us;
    }
    rest.remove_prefix(decimals);
    digits += decimals;
  }
  if (rest.empty() && digits > 0) {
    const int64_t stamp_us = seconds * kMicroseconds + fraction_us;
    if (stamp_us > kMaxTimestamp_us) return std::nullopt;
    return negative ? -stamp_us : stamp_us;
  }
  // Scientific notation, as numerical packages write it.
  const std::optional<double> value = parse_number(text);
  if (!value || !(std::abs(*value) <= static_cast<double>(kMaxSeconds))) return std::nullopt;
  return std::llround(*value * 1e6);
}

std::string format_stamp_us(int64_t stamp_us) {
  const uint64_t magnitude =
      stamp_us < 0 ? 0 - static_cast<uint64_t>(stamp_us) : static_cast<uint64_t>(stamp_us);
  const std::string fraction =
      std::to_string(kMicroseconds + static_cast<int64_t>(magnitude % kMicroseconds)).substr(1);
  return std::string(stamp_us < 0 ? "-" : "") + std::to_string(magnitude / kMicroseconds) + "." + fraction;
}

bool TextLines::next() {
  constexpr std::string_view kBlanks = " \t\r,";
  while (!rest_.empty()) {
    ++line_;
    const size_t end = rest_.find('\n');
    std::string_view line = rest_.substr(0, end);
    rest_.remove_prefix(end == std::string_view::npos ? rest_.size() : end + 1);
    fields_.clear();
    while (true) {
      const size_t first = line.find_first_not_of(kBlanks);
      if (first == std::string_view::npos) break;
      line.remove_prefix(first);
      fields_.push_back(line.substr(0, line.find_first_of(kBlanks)));
      line.remove_prefix(fields_.back().size());
    }
    if (!fields_.empty() && !fields_[0].starts_with('#')) return true;
  }
  fields_.clear();
  return false;
}

void TextLines::expect_fields(size_t count, const char* layout) const {
  if (fields_.size() == count) return;
  fail(std::string("has ") + std::to_string(fields_.size()) + " fields, expected " + std::to_string(count) +
       ": " + layout);
}

std::string_view TextLines::field(size_t i) const {
  if (i >= fields_.size()) fail(std::string("field ") + std::to_string(i + 1) + " is missing");
  return fields_[i];
}

double TextLines::number(size_t i) const {
  const std::optional<double> value = parse_number(field(i));
  if (!value || !std::isfinite(*value)) fail("'" + std::string(fields_[i]) + "' is not a finite number");
  return *value;
}

int64_t TextLines::integer(size_t i) const {
  const std::optional<int64_t> value = parse_integer(field(i));
  if (!value) fail("'" + std::string(fields_[i]) + "' is not an integer");
  return *value;
}

int64_t TextLines::stamp_us(size_t i) const {
  const std::optional<int64_t> value = parse_stamp_us(field(i));
  if (!value) {
    fail("'" + std::string(fields_[i]) + "' is not a time in seconds" +
         (parse_number(fields_[i]) ? " (milliseconds?)" : ""));
  }
  return *value;
}

void TextLines::fail(const std::string& what) const {
  throw Error(name_ + ", line " + std::to_string(line_) + ": " + what);
}

}  // namespace kt
