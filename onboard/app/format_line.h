// A line of a report, formatted as printf does.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdio>
#include <string>

namespace kt {

/// At most 255 characters of it.
template <typename... Values>
std::string format_line(const char* pattern, Values... values) {
  char line[256];
  std::snprintf(line, sizeof(line), pattern, values...);
  return line;
}

}  // namespace kt
