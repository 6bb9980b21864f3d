// Files that changed are told from what they were.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/stages/file_identity.h"

#include <gtest/gtest.h>

#include "shared/core/check.h"
#include "shared/io/file.h"
#include "tests/support/test_files.h"

namespace kt {
namespace {

namespace fs = std::filesystem;

TEST(FileIdentity, DigestIsOfTheContent) {
  const ScratchDir folder;
  const std::string content(200'000, 'x');
  write_file(folder / "a", content);
  Digest digest;
  digest.add_bytes(content.data(), content.size());
  EXPECT_EQ(digest_of_file(folder / "a").digest.hex(), digest.hex());
  EXPECT_EQ(digest_of_file(folder / "a").bytes, 200'000);
  EXPECT_THROW(digest_of_file(folder / "b"), Error);
}

TEST(FileIdentity, AFileIsItselfWhereverItLies) {
  const ScratchDir folder;
  write_file(folder / "a", "abc");
  const std::string before = identity_of(folder / "a").hex();
  EXPECT_EQ(identity_of(folder / "a").hex(), before);
  fs::rename(folder / "a", folder / "b");
  EXPECT_EQ(identity_of(folder / "b").hex(), before);
  fs::last_write_time(folder / "b", fs::last_write_time(folder / "b") + std::chrono::seconds(1));
  EXPECT_NE(identity_of(folder / "b").hex(), before);
  EXPECT_THROW(identity_of(folder / "a"), Error);
}

TEST(FileIdentity, ContentCountsWhereTimeAndSizeAreTheSame) {
  const ScratchDir folder;
  std::string content(3'000'000, 'x');
  write_file(folder / "a", content);
  const std::string before = identity_of(folder / "a").hex();
  const auto time = fs::last_write_time(folder / "a");
  for (const size_t at : {size_t{0}, content.size() / 15, content.size() - 1}) {
    std::string other = content;
    other[at] = 'y';
    write_file(folder / "a", other);
    fs::last_write_time(folder / "a", time);
    EXPECT_NE(identity_of(folder / "a").hex(), before) << at;
  }
  write_file(folder / "a", content);
  fs::last_write_time(folder / "a", time);
  EXPECT_EQ(identity_of(folder / "a").hex(), before);
}

TEST(FileIdentity, OfAFolderAllFilesCount) {
  const ScratchDir folder;
  fs::create_directories(folder / "r/depth");
  write_file(folder / "r/depth/1.png", "1");
  write_file(folder / "r/depth.txt", "x");
  const std::string before = identity_of(folder / "r").hex();
  EXPECT_EQ(identity_of(folder / "r").hex(), before);
  fs::rename(folder / "r/depth/1.png", folder / "r/depth/2.png");
  const std::string renamed = identity_of(folder / "r").hex();
  EXPECT_NE(renamed, before);
  write_file(folder / "r/depth/3.png", "1");
  EXPECT_NE(identity_of(folder / "r").hex(), renamed);
}

}  // namespace
}  // namespace kt
