// Stages are made once, taken afterwards, and made again where that is needed.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/stages/stage_runner.h"

#include <gtest/gtest.h>

#include "shared/core/check.h"
#include "shared/io/file.h"
#include "tests/offboard/stages/made_key.h"
#include "tests/support/test_files.h"

namespace kt {
namespace {

using test::key_of;

struct Outcome {
  std::vector<double> result;
  bool was_made = false, was_restored = false;
  std::vector<StageDone> done;
  std::vector<std::string> notes;
  std::vector<std::pair<std::string, double>> told;
};

Outcome run(const std::filesystem::path& folder, int key, bool make_all = false, bool keeps = true) {
  Outcome outcome;
  const StageProgress progress = [&](const std::string& stage, double share, double) {
    outcome.told.emplace_back(stage, share);
  };
  StageStore store(folder, keeps);
  StageRunner stages(store, progress);
  if (make_all) stages.make_all();
  outcome.result = stages.run(
      "square", key_of(key),
      [&](const TellShare& tell) {
        tell(0.5);
        tell(1);
        outcome.was_made = true;
        return std::vector<double>{static_cast<double>(key) * key};
      },
      [&](const std::vector<double>&, const TellShare&) { outcome.was_restored = true; });
  outcome.done = stages.done();
  outcome.notes = stages.notes();
  return outcome;
}

TEST(StageRunner, TakesWhatAnEarlierRunHasMade) {
  const ScratchDir folder;
  const Outcome first = run(folder / "stages", 3);
  EXPECT_TRUE(first.was_made && !first.was_restored && !first.done[0].is_from_file);
  const std::vector<std::pair<std::string, double>> told{{"square", 0}, {"square", 0.5}, {"square", 1}};
  EXPECT_EQ(first.told, told);
  const Outcome second = run(folder / "stages", 3);
  EXPECT_TRUE(!second.was_made && second.was_restored && second.done[0].is_from_file);
  EXPECT_EQ(second.result, std::vector<double>{9});
  EXPECT_EQ(second.done[0].seconds_to_make, StageStore(folder / "stages", true).record("square").seconds);
  EXPECT_EQ(second.told.back(), std::pair(std::string("square"), 1.0));
}

TEST(StageRunner, MakesWhatHasChangedOrIsWanted) {
  const ScratchDir folder;
  run(folder / "stages", 3);
  EXPECT_EQ(run(folder / "stages", 4).result, std::vector<double>{16});
  EXPECT_TRUE(run(folder / "stages", 4, true).was_made);
  EXPECT_FALSE(run(folder / "stages", 4).was_made);
}

TEST(StageRunner, ADamagedFileIsMadeAnewAndTold) {
  const ScratchDir folder;
  EXPECT_TRUE(run(folder / "stages", 3).notes.empty());
  write_file(folder / "stages/square", "rubbish");
  const Outcome again = run(folder / "stages", 3);
  EXPECT_EQ(again.result, std::vector<double>{9});
  ASSERT_EQ(again.notes.size(), 1u);
  EXPECT_NE(again.notes[0].find((folder / "stages/square").string()), std::string::npos);
  EXPECT_TRUE(run(folder / "stages", 3).notes.empty());
}

TEST(StageRunner, WithoutKeepingAllIsMade) {
  const ScratchDir folder;
  EXPECT_TRUE(run(folder / "stages", 3, false, false).was_made);
  EXPECT_TRUE(run(folder / "stages", 3, false, false).was_made);
  EXPECT_FALSE(std::filesystem::exists(folder / "stages"));
}

TEST(StageRunner, WhatFailsLeavesNothing) {
  const ScratchDir folder;
  StageStore store(folder / "stages", true);
  const StageProgress nobody;
  StageRunner stages(store, nobody);
  const auto fail = [&](const TellShare&) -> std::vector<double> {
    store.open();
    write_file(store.part("square", 1), "half of it");
    throw Error("the disk is full");
  };
  EXPECT_THROW(stages.run("square", key_of(1), fail), Error);
  EXPECT_TRUE(std::filesystem::is_empty(folder / "stages"));
}

}  // namespace
}  // namespace kt
