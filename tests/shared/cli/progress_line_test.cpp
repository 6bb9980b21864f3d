// What the progress line writes to a terminal and to a file.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/cli/progress_line.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

namespace kt {
namespace {

/// Runs `work` with a file to write to and returns what it wrote.
template <typename Work>
std::string written_to_a_file(const Work& work) {
  std::FILE* file = std::tmpfile();
  work(file);
  std::rewind(file);
  char text[2000];
  const size_t size = std::fread(text, 1, sizeof text, file);
  std::fclose(file);
  return {text, size};
}

/// The same with a terminal.
template <typename Work>
std::string written_to_a_terminal(const Work& work) {
  const int master = ::posix_openpt(O_RDWR | O_NOCTTY);
  if (master < 0 || ::grantpt(master) != 0 || ::unlockpt(master) != 0) return "no terminal";
  std::FILE* terminal = ::fdopen(::open(::ptsname(master), O_RDWR | O_NOCTTY), "w");
  work(terminal);
  std::fflush(terminal);
  std::fputc('\x04', terminal);  // what is written comes in pieces: read on until this
  std::fflush(terminal);
  std::string text;
  char piece[4000];
  while (text.find('\x04') == std::string::npos) {
    const ssize_t size = ::read(master, piece, sizeof piece);
    if (size <= 0) break;
    text.append(piece, static_cast<size_t>(size));
  }
  std::fclose(terminal);
  ::close(master);
  return text.substr(0, text.find('\x04'));
}

TEST(ProgressLine, IsSilentInAFileButForTheEnd) {
  const std::string text = written_to_a_file([](std::FILE* file) {
    ProgressLine progress(file);
    for (int i = 1; i <= 600; ++i) progress.show(i / 600.0, "frame " + std::to_string(i) + " of 600");
  });
  EXPECT_EQ(text, "frame 600 of 600 (100 %)\n");
}

TEST(ProgressLine, RedrawsABarOnATerminal) {
  const std::string text = written_to_a_terminal([](std::FILE* terminal) {
    ProgressLine progress(terminal);
    progress.show(0.5, "frame 1 of 2");
    progress.show(1, "frame 2 of 2");
  });
  if (text == "no terminal") GTEST_SKIP() << "this system gives out no pseudo terminal";
  EXPECT_EQ(text.rfind("\r[######      ]  50 %  frame 1 of 2 ", 0), 0u) << text;
  EXPECT_NE(text.find("\r[############] 100 %  frame 2 of 2 "), std::string::npos) << text;
  EXPECT_EQ(text.back(), '\n');
}

TEST(ProgressLine, EndsItsLineWhereTheWayIsCutShort) {
  const std::string text = written_to_a_terminal([](std::FILE* terminal) {
    ProgressLine progress(terminal);
    progress.show(-1, "frame 7");
  });
  if (text == "no terminal") GTEST_SKIP() << "this system gives out no pseudo terminal";
  EXPECT_EQ(text.rfind("\rframe 7 ", 0), 0u) << text;
  EXPECT_EQ(text.back(), '\n');
}

}  // namespace
}  // namespace kt
