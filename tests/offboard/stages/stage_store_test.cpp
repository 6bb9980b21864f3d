// A stage's file is found where it is whole and made from the same, and not otherwise.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/stages/stage_store.h"

#include <gtest/gtest.h>

#include "shared/core/check.h"
#include "shared/io/file.h"
#include "tests/offboard/stages/made_key.h"
#include "tests/support/test_files.h"

namespace kt {
namespace {

using test::key_of;

using State = StageStore::State;

void keep(StageStore& store, const std::string& content, int key = 1) {
  store.clear("loops");
  store.open();
  write_file(store.file("loops"), content);
  store.finish("loops", key_of(key), 2.5);
}

TEST(StageStore, FindsWhatItKept) {
  const ScratchDir folder;
  StageStore store(folder / "new/stages", true);
  EXPECT_EQ(store.state("loops", key_of(1)), State::kMissing);
  keep(store, "abc");
  EXPECT_EQ(store.state("loops", key_of(1)), State::kWhole);
  EXPECT_EQ(store.state("load", key_of(1)), State::kMissing);
  EXPECT_EQ(read_file(store.file("loops")), "abc");
  const StageRecord record = store.record("loops");
  EXPECT_EQ(record.seconds, 2.5);
  ASSERT_EQ(record.files.size(), 1u);
  EXPECT_EQ(record.files[0].name, "loops");
  EXPECT_EQ(record.files[0].bytes, 3);
}

TEST(StageStore, AnotherKeyIsAnotherResult) {
  const ScratchDir folder;
  StageStore store(folder / "stages", true);
  keep(store, "abc");
  EXPECT_EQ(store.state("loops", key_of(2)), State::kOtherKey);
  keep(store, "d", 2);
  EXPECT_EQ(store.state("loops", key_of(2)), State::kWhole);
  EXPECT_EQ(store.state("loops", key_of(1)), State::kOtherKey);
}

TEST(StageStore, DamageIsFound) {
  const ScratchDir folder;
  StageStore store(folder / "stages", true);
  for (const char* content : {"abd", "ab", "abcd", ""}) {
    keep(store, "abc");
    write_file(store.file("loops"), content);
    EXPECT_EQ(store.state("loops", key_of(1)), State::kDamaged) << content;
  }
  keep(store, "abc");
  std::filesystem::remove(store.file("loops"));
  EXPECT_EQ(store.state("loops", key_of(1)), State::kDamaged);
  for (const char* record : {"", "{", "{}", "[1]", R"({"key": 1, "files": [], "seconds": 1})"}) {
    keep(store, "abc");
    write_file(folder / "stages/loops.json", record);
    EXPECT_EQ(store.state("loops", key_of(1)), State::kDamaged) << record;
  }
}

TEST(StageStore, PartsBelongToTheirStage) {
  const ScratchDir folder;
  StageStore store(folder / "stages", true);
  const auto keep_parts = [&] {
    store.clear("fuse");
    store.open();
    for (const int number : {0, 12}) write_file(store.part("fuse", number), "part");
    write_file(store.file("fuse"), "all");
    store.finish("fuse", key_of(1), 1);
  };
  keep_parts();
  EXPECT_EQ(store.record("fuse").files.size(), 3u);
  EXPECT_EQ(store.state("fuse", key_of(1)), State::kWhole);
  write_file(folder / "stages/fuse-12", "Part");
  EXPECT_EQ(store.state("fuse", key_of(1)), State::kDamaged);
  keep_parts();
  std::filesystem::remove(folder / "stages/fuse-0");
  EXPECT_EQ(store.state("fuse", key_of(1)), State::kDamaged);
  keep(store, "abc");
  EXPECT_TRUE(std::filesystem::exists(folder / "stages/fuse-12")) << "of another stage";
  store.clear("fuse");
  EXPECT_FALSE(std::filesystem::exists(folder / "stages/fuse-12"));
}

// Whatever step the work ends at, no file is taken for more than it is.
TEST(StageStore, AnInterruptedWriteLeavesNothingThatCounts) {
  const ScratchDir folder;
  {
    StageStore store(folder / "stages", true);
    keep(store, "abc");
    store.clear("loops");
    write_file(store.file("loops"), "abc");  // killed here
  }
  StageStore store(folder / "stages", true);
  EXPECT_EQ(store.state("loops", key_of(1)), State::kMissing);
  write_file(folder / "stages/loops.json.tmp", "or killed here");
  EXPECT_EQ(store.state("loops", key_of(1)), State::kMissing);
  keep(store, "abc");
  EXPECT_EQ(store.state("loops", key_of(1)), State::kWhole);
  EXPECT_FALSE(std::filesystem::exists(folder / "stages/loops.json.tmp"));
  store.clear("loops");
  EXPECT_TRUE(std::filesystem::is_empty(folder / "stages"));
}

TEST(StageStore, OneProcessAtATime) {
  const ScratchDir folder;
  {
    StageStore store(folder / "stages", true);
    keep(store, "abc");
    EXPECT_THROW(StageStore(folder / "stages", true), Error);
  }
  EXPECT_EQ(StageStore(folder / "stages", true).state("loops", key_of(1)), State::kWhole);
}

TEST(StageStore, WhatIsNotKeptIsRemoved) {
  const ScratchDir folder;
  {
    StageStore store(folder / "stages", false);
    keep(store, "abc");
    EXPECT_EQ(read_file(store.file("loops")), "abc");
    EXPECT_EQ(store.state("loops", key_of(1)), State::kMissing);
  }
  EXPECT_FALSE(std::filesystem::exists(folder / "stages"));
}

TEST(StageStore, AFolderThatCannotBeMadeIsAnError) {
  const ScratchDir folder;
  write_file(folder / "file", "x");
  StageStore store(folder / "file/stages", true);
  store.clear("loops");
  EXPECT_THROW(store.open(), Error);
}

}  // namespace
}  // namespace kt
