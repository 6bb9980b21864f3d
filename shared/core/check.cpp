// The failing branch of KT_CHECK, kept out of line.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/core/check.h"

namespace kt {

void throw_check_failed(const char* condition, const char* file, int line, const std::string& note) {
  std::string text =
      std::string("internal error: ") + condition + " does not hold at " + file + ":" + std::to_string(line);
  if (!note.empty()) text += ": " + note;
  throw LogicError(text);
}

}  // namespace kt
