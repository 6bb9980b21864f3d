// Files are replaced and removed; what is none, a device above all, stays where it is.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/io/file.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include "shared/core/scratch_file.h"
#include "tests/support/test_files.h"

namespace kt {
namespace {

namespace fs = std::filesystem;

/// Pipes stand for devices: they can be made without being root, and lost in the same ways.
class NoFile : public testing::Test {
 protected:
  NoFile() { EXPECT_EQ(::mkfifo(pipe.c_str(), 0600), 0); }
  bool pipe_is_there() const { return fs::is_fifo(fs::symlink_status(pipe)); }

  const ScratchDir folder;
  const fs::path pipe = folder / "pipe";
};

TEST_F(NoFile, IsNeitherRemovedNorReplaced) {
  write_file(folder / "a", "text");
  EXPECT_NE(error_of([&] { remove_file(pipe); }).find("pipe: is no file"), std::string::npos);
  EXPECT_NE(error_of([&] { rename_file(folder / "a", pipe); }).find("pipe: is no file"), std::string::npos);
  EXPECT_TRUE(pipe_is_there());
  EXPECT_TRUE(fs::exists(folder / "a"));
  fs::create_symlink(pipe, folder / "link");
  EXPECT_NE(error_of([&] { remove_file(folder / "link"); }), "");
  EXPECT_NE(error_of([&] { remove_file(folder.path()); }), "");
}

TEST_F(NoFile, IsWrittenThroughAndStaysWhereThatFails) {
  EXPECT_NE(error_of([] { write_file("/dev/full", "text"); }).find("/dev/full"), std::string::npos);
  EXPECT_TRUE(fs::is_character_file("/dev/full"));
  write_file("/dev/null", "text");
  EXPECT_TRUE(fs::is_character_file("/dev/null"));
}

TEST_F(NoFile, IsNoScratchFile) {
  fs::create_symlink("/dev/null", folder / "device");
  EXPECT_NE(error_of([&] { ScratchFile(folder / "device", "nothing"); }).find("is no file"),
            std::string::npos);
  EXPECT_TRUE(fs::exists(folder / "device"));
  EXPECT_TRUE(fs::is_character_file("/dev/null"));
}

TEST(File, IsRemovedAndReplaced) {
  const ScratchDir folder;
  write_file(folder / "a", "first");
  write_file(folder / "b", "second");
  fs::create_symlink(folder / "a", folder / "link");
  remove_file(folder / "none");
  remove_file(folder / "link");
  EXPECT_TRUE(fs::exists(folder / "a"));
  rename_file(folder / "b", folder / "a");
  EXPECT_EQ(read_file(folder / "a"), "second");
  EXPECT_FALSE(fs::exists(folder / "b"));
  remove_file(folder / "a");
  EXPECT_FALSE(fs::exists(folder / "a"));
}

}  // namespace
}  // namespace kt
