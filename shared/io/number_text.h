// Numbers as text, independent of the locale.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <charconv>
#include <string>

namespace kt {

/// The shortest text that reads back as the same double.
inline std::string number_text(double value) {
  char text[32];
  return {text, std::to_chars(text, text + sizeof text, value).ptr};
}

/// With exactly `decimals` (at most 17) digits after the point.
inline std::string fixed_text(double value, int decimals) {
  char text[384];  // the largest double has 309 digits before the point
  return {text, std::to_chars(text, text + sizeof text, value, std::chars_format::fixed, decimals).ptr};
}

}  // namespace kt
