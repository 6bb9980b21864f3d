// Walks the meaningful lines of a text file, field by field, with errors that name file and line.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace kt {

/// Time in microseconds of a decimal number of seconds ("1305031102.160407"), exact to the sixth decimal;
/// nothing where the text is no number or beyond kMaxTimestamp_us.
std::optional<int64_t> parse_stamp_us(std::string_view text);
/// The inverse: seconds with six decimals.
std::string format_stamp_us(int64_t stamp_us);

/// Independent of the locale; nothing where `text` holds anything but one number.
std::optional<double> parse_number(std::string_view text);
std::optional<int64_t> parse_integer(std::string_view text);

/// Skips blank lines and those that start with '#'. Fields are separated by blanks, tabs or commas.
class TextLines {
 public:
  /// `text` must outlive this object; `name` is the file for error messages.
  TextLines(std::string name, std::string_view text) : name_(std::move(name)), rest_(text) {}

  /// Moves to the next line; false at the end.
  bool next();

  const std::vector<std::string_view>& fields() const { return fields_; }
  /// Throws unless the line has `count` fields; `layout` says what they should be.
  void expect_fields(size_t count, const char* layout) const;

  /// Field `i` as a finite number, an integer or a time stamp (us); each throws kt::Error where it is none.
  double number(size_t i) const;
  int64_t integer(size_t i) const;
  int64_t stamp_us(size_t i) const;

  /// Throws kt::Error "<file>, line <n>: <what>".
  [[noreturn]] void fail(const std::string& what) const;

 private:
  std::string_view field(size_t i) const;

  std::string name_;
  std::string_view rest_;
  int64_t line_ = 0;
  std::vector<std::string_view> fields_;
};

}  // namespace kt
