// Layout of JSON: one member per line, two blanks per level.
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/bench/json_text.h"

#include <cmath>
#include <cstdio>

#include "shared/core/check.h"

namespace kt::bench {
namespace {

std::string quoted(const std::string& text) {
  std::string result = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') result += '\\';
    result += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
  }
  return result + '"';
}

}  // namespace

void JsonText::start_member(const char* key) {
  if (open_.empty()) return;
  if (!is_first_) text_ += ',';
  is_first_ = false;
  text_ += '\n' + std::string(2 * open_.size(), ' ');
  if (key) text_ += quoted(key) + ": ";
}

void JsonText::add_text(const char* key, const std::string& text) {
  start_member(key);
  text_ += text;
}

void JsonText::add(const char* key, const std::string& value) { add_text(key, quoted(value)); }

void JsonText::add(const char* key, double value, int digits) {
  char text[64];
  std::snprintf(text, sizeof(text), "%.*f", digits, value);
  add_text(key, std::isfinite(value) ? text : "null");
}

void JsonText::open_bracket(const char* key, char bracket) {
  start_member(key);
  text_ += bracket;
  open_ += bracket;
  is_first_ = true;
}

void JsonText::close() {
  KT_CHECK(!open_.empty(), "nothing is open");
  const bool was_empty = is_first_;
  const char bracket = open_.back();
  open_.pop_back();
  if (!was_empty) text_ += '\n' + std::string(2 * open_.size(), ' ');
  text_ += bracket == '{' ? '}' : ']';
  is_first_ = false;
}

std::string JsonText::finish() {
  close();
  KT_CHECK(open_.empty(), "an object is still open");
  return text_ + '\n';
}

}  // namespace kt::bench
