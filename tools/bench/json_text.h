// Writes JSON line by line: the core has no library for it.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <concepts>
#include <cstdint>
#include <string>

namespace kt::bench {

/// One JSON object, built member by member in the order of the calls.
class JsonText {
 public:
  JsonText() { open_bracket(nullptr, '{'); }

  void add(const char* key, const std::string& value);
  void add(const char* key, const char* value) { add(key, std::string(value)); }
  /// Null where the number is not finite.
  void add(const char* key, double value, int digits);
  void add(const char* key, std::integral auto value) { add_text(key, std::to_string(value)); }

  /// An object as a member of what is open; without a key in an array. Close it with close().
  void open(const char* key = nullptr) { open_bracket(key, '{'); }
  void open_array(const char* key) { open_bracket(key, '['); }
  void close();

  /// The whole, once every open() has its close().
  std::string finish();

 private:
  void add_text(const char* key, const std::string& text);
  void open_bracket(const char* key, char bracket);
  void start_member(const char* key);

  std::string text_, open_;  // `open_`: the brackets not yet closed
  bool is_first_ = true;     // of its object or array
};

}  // namespace kt::bench
