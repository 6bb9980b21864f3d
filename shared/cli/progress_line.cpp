// Draws the bar, or writes a line now and then.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/cli/progress_line.h"

#include <algorithm>
#include <unistd.h>

namespace kt {
namespace {

constexpr int kColumns = 79;  // a line that wraps cannot be redrawn
constexpr size_t kBarColumns = 12;

std::string percent_text(double share) {
  return std::to_string(static_cast<int>(100 * std::min(share, 1.0))) + " %";
}

std::string bar_text(double share) {
  const auto done = static_cast<size_t>(static_cast<double>(kBarColumns) * std::min(share, 1.0));
  std::string percent = percent_text(share);
  percent.insert(0, 5 - percent.size(), ' ');
  return "[" + std::string(done, '#') + std::string(kBarColumns - done, ' ') + "] " + percent + "  ";
}

}  // namespace

ProgressLine::ProgressLine(std::FILE* out)
    : out_(out), is_terminal_(::isatty(::fileno(out)) != 0), last_(Clock::now()) {}

void ProgressLine::show(double share, const std::string& text) {
  const Clock::time_point now = Clock::now();
  const bool ends = share >= 1;
  if (is_terminal_) {
    if (!ends && is_open_ && now - last_ < std::chrono::milliseconds(100)) return;
    const std::string line = (share < 0 ? std::string() : bar_text(share)) + text;
    std::fprintf(out_, "\r%-*.*s%s", kColumns, kColumns, line.c_str(), ends ? "\n" : "");
    std::fflush(out_);
    is_open_ = !ends;
  } else {
    if (!ends && now - last_ < std::chrono::seconds(10)) return;
    std::fprintf(out_, "%s%s\n", text.c_str(), share < 0 ? "" : (" (" + percent_text(share) + ")").c_str());
  }
  last_ = now;
}

void ProgressLine::end() {
  if (is_open_) std::fputc('\n', out_);
  is_open_ = false;
}

}  // namespace kt
