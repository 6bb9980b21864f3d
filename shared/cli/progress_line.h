// How far a program has come, on standard error.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstdio>
#include <string>

namespace kt {

/// On a terminal a bar that is redrawn in place; elsewhere a line every ten seconds and one at the end of the
/// way, so that logs stay short. Cheap enough to be called for every frame. Not to be shared by threads.
class ProgressLine {
 public:
  explicit ProgressLine(std::FILE* out = stderr);
  ~ProgressLine() { end(); }
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;

  /// `share` of the way in [0, 1], or below 0 where nobody knows; `text` says of what. 1 ends the line: a
  /// next call begins another.
  void show(double share, const std::string& text);
  /// Leaves the bar as it is and goes to the next line; for ways that end before their end.
  void end();

 private:
  using Clock = std::chrono::steady_clock;

  std::FILE* out_;
  bool is_terminal_;
  bool is_open_ = false;  // a bar stands on the terminal's current line
  Clock::time_point last_;
};

}  // namespace kt
