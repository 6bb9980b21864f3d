// A stage's file is found where it is whole and made from the same, and not otherwise.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/stages/stage_store.h"

#include <gtest/gtest.h>

#include "shared/core/check.h"
#include "shared/io/file.h"
#include "tests/support/test_files.h"

namespace kt {
namespace {

using State = StageStore::State;

Digest key_of(int number) {
  Digest digest;
  digest.add(number);
  return digest;
}

void keep(StageStore& store, const std::string& content, int key = 1) {
  store.keep("loops", key_of(key), 2.5,
             [&](const std::filesystem::path& path) { write_file(path, content); });
}

TEST(StageStore, FindsWhatItKept) {
  const ScratchDir folder;
  StageStore store(folder / "new/stages");
  EXPECT_EQ(store.state("loops", key_of(1)), State::kMissing);
  keep(store, "abc");
  EXPECT_EQ(store.state("loops", key_of(1)), State::kWhole);
  EXPECT_EQ(store.state("load", key_of(1)), State::kMissing);
  EXPECT_EQ(read_file(store.file("loops")), "abc");
  EXPECT_EQ(store.record("loops").seconds, 2.5);
  EXPECT_EQ(store.record("loops").bytes, 3);
}

TEST(StageStore, AnotherKeyIsAnotherResult) {
  const ScratchDir folder;
  StageStore store(folder / "stages");
  keep(store, "abc");
  EXPECT_EQ(store.state("loops", key_of(2)), State::kOtherKey);
  keep(store, "d", 2);
  EXPECT_EQ(store.state("loops", key_of(2)), State::kWhole);
  EXPECT_EQ(store.state("loops", key_of(1)), State::kOtherKey);
}

TEST(StageStore, DamageIsFound) {
  const ScratchDir folder;
  StageStore store(folder / "stages");
  for (const char* content : {"abd", "ab", "abcd", ""}) {
    keep(store, "abc");
    write_file(store.file("loops"), content);
    EXPECT_EQ(store.state("loops", key_of(1)), State::kDamaged) << content;
  }
  keep(store, "abc");
  std::filesystem::remove(store.file("loops"));
  EXPECT_EQ(store.state("loops", key_of(1)), State::kDamaged);
  for (const char* record :
       {"", "{", "{}", "[1]", R"({"key": 1, "bytes": 3, "digest": "x", "seconds": 1})"}) {
    keep(store, "abc");
    write_file(folder / "stages/loops.json", record);
    EXPECT_EQ(store.state("loops", key_of(1)), State::kDamaged) << record;
  }
}

// Whatever step the work ends at, no file is taken for more than it is.
TEST(StageStore, AnInterruptedWriteLeavesNothingBehind) {
  const ScratchDir folder;
  StageStore store(folder / "stages");
  keep(store, "abc");
  EXPECT_THROW(store.keep("loops", key_of(1), 1,
                          [&](const std::filesystem::path& path) {
                            write_file(path, "ab");
                            EXPECT_EQ(store.state("loops", key_of(1)), State::kMissing)
                                << "as kill -9 sees it";
                            throw Error("the disk is full");
                          }),
               Error);
  EXPECT_EQ(store.state("loops", key_of(1)), State::kMissing);
  EXPECT_TRUE(std::filesystem::is_empty(folder / "stages"));
  write_file(folder / "stages/loops.tmp", "what a killed run has left");
  keep(store, "abc");
  EXPECT_EQ(store.state("loops", key_of(1)), State::kWhole);
  EXPECT_FALSE(std::filesystem::exists(folder / "stages/loops.tmp"));
}

TEST(StageStore, OneProcessAtATime) {
  const ScratchDir folder;
  {
    StageStore store(folder / "stages");
    keep(store, "abc");
    EXPECT_THROW(StageStore(folder / "stages"), Error);
  }
  EXPECT_EQ(StageStore(folder / "stages").state("loops", key_of(1)), State::kWhole);
}

TEST(StageStore, WithoutAFolderNothingIsKept) {
  StageStore store({});
  keep(store, "abc");
  EXPECT_EQ(store.state("loops", key_of(1)), State::kMissing);
}

TEST(StageStore, AFolderThatCannotBeMadeIsAnError) {
  const ScratchDir folder;
  write_file(folder / "file", "x");
  StageStore store(folder / "file/stages");
  EXPECT_THROW(keep(store, "abc"), Error);
}

}  // namespace
}  // namespace kt
