// Tests of the bricks in a file.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/reintegration/brick_store.h"

#include <csignal>
#include <cstring>
#include <sys/resource.h>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

#include "shared/core/check.h"
#include "tests/support/test_files.h"

namespace kt::test {
namespace {

StoredBrick brick_at(Vec3i place, uint32_t content) {
  StoredBrick brick;
  brick.brick = place;
  brick.last_seen = content;
  brick.voxels[content % kBrickVoxels].word = content;
  return brick;
}

std::vector<uint32_t> contents(const BrickStore& store, const VoxelBounds& bounds) {
  std::vector<uint32_t> found;
  store.read(bounds, [&](auto bricks) {
    for (const StoredBrick& brick : bricks) {
      const StoredBrick expected = brick_at(brick.brick, brick.last_seen);
      EXPECT_EQ(std::memcmp(&brick, &expected, sizeof(brick)), 0);
      found.push_back(brick.last_seen);
    }
  });
  return found;
}

constexpr VoxelBounds kAll{{-1000, -1000, -1000}, {1000, 1000, 1000}};

TEST(BrickStore, GivesBackWhatItWasGivenInOrder) {
  const ScratchDir folder;
  BrickStore store(folder / "bricks");
  EXPECT_TRUE(contents(store, kAll).empty());
  const std::vector<StoredBrick> bricks{brick_at({3, -2, 1}, 7), brick_at({-4, 0, -1}, 8),
                                        brick_at({2, -2, 1}, 9)};
  store.put(bricks);
  EXPECT_THAT(contents(store, kAll), testing::ElementsAre(8, 9, 7));
  EXPECT_THAT(contents(store, {{16, -16, 8}, {24, -8, 16}}), testing::ElementsAre(9));
  EXPECT_THAT(contents(store, {{17, -16, 8}, {24, -8, 16}}), testing::IsEmpty()) << "it begins before";
  store.put(std::vector<StoredBrick>{brick_at({-4, 0, -1}, 10)});
  EXPECT_THAT(contents(store, kAll), testing::ElementsAre(10, 9, 7));
  ASSERT_EQ(store.blocks().size(), 2u) << "two bricks share one";
  EXPECT_EQ(store.blocks()[0].x, -1);
  EXPECT_EQ(store.blocks()[1].x, 0);
}

TEST(BrickStore, UsesThePlacesOfForgottenBricksAgain) {
  const ScratchDir folder;
  const auto file = folder / "bricks";
  {
    BrickStore store(file);
    for (int round = 0; round < 5; ++round) {
      for (int x = 0; x < 10; ++x)
        store.put(std::vector<StoredBrick>{brick_at({x, 0, 0}, static_cast<uint32_t>(100 * round + x))});
      store.erase({{0, 0, 0}, {64, 8, 8}});
      EXPECT_THAT(contents(store, kAll), testing::ElementsAre(100 * round + 8, 100 * round + 9));
    }
    EXPECT_EQ(std::filesystem::file_size(file), 10 * sizeof(StoredBrick));
  }
  EXPECT_FALSE(std::filesystem::exists(file)) << "it is of no use any more";
}

TEST(BrickStore, NamesTheFileThatCannotBeMade) {
  const ScratchDir folder;
  try {
    const BrickStore store(folder / "missing" / "bricks");
    FAIL() << "no error";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(),
                testing::AllOf(testing::HasSubstr("missing/bricks"), testing::HasSubstr("room")));
  }
}

TEST(BrickStore, AFullDiskIsToldOf) {
  const ScratchDir folder;
  BrickStore store(folder / "bricks");
  // A file at its limit fails to grow as one on a full disk does, once the signal is ignored.
  const auto before = std::signal(SIGXFSZ, SIG_IGN);
  rlimit limit{};
  getrlimit(RLIMIT_FSIZE, &limit);
  const rlimit small{1000, limit.rlim_max};
  setrlimit(RLIMIT_FSIZE, &small);
  EXPECT_THROW(store.put(std::vector<StoredBrick>{brick_at({0, 0, 0}, 1)}), Error);
  setrlimit(RLIMIT_FSIZE, &limit);
  std::signal(SIGXFSZ, before);
}

}  // namespace
}  // namespace kt::test
