// Tests of blocks that are used again.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/exec/block_pool.h"

#include <optional>
#include <set>

#include "gtest/gtest.h"

#include "tests/support/devices.h"

namespace kt::exec {
namespace {

std::vector<float> content(const Device& device, const BlockPool<float>::Block& block, size_t size) {
  std::vector<float> values(size);
  copy_to_host(device, values.data(), block.get(), size * sizeof(float));
  return values;
}

TEST(BlockPool, BlocksAreApart) {
  for (const Device& device : test::parity_devices()) {
    BlockPool<float> pool(device, 65, 3);
    std::vector<BlockPool<float>::Block> blocks;
    for (int i = 0; i < 3; ++i) {
      blocks.push_back(pool.take());
      EXPECT_EQ(content(device, blocks.back(), 65), std::vector<float>(65)) << "zeroed";
      const std::vector<float> values(65, static_cast<float>(i));
      copy_to_device(device, blocks.back().get(), values.data(), 65 * sizeof(float));
    }
    for (int i = 0; i < 3; ++i) {
      const auto& block = blocks[static_cast<size_t>(i)];
      EXPECT_EQ(content(device, block, 65), std::vector<float>(65, static_cast<float>(i)));
      EXPECT_EQ((block.get() - blocks[0].get()) * sizeof(float) % 256, 0u);
    }
  }
}

TEST(BlockPool, GivesOutNoMoreThanItHas) {
  BlockPool<int32_t> pool(Device::cpu(1), 10, 2);
  EXPECT_EQ(pool.block_size(), 10);
  auto first = pool.take(), second = pool.take();
  EXPECT_EQ(pool.free_blocks(), 0);
  EXPECT_THROW(pool.take(), LogicError);
  EXPECT_THROW(BlockPool<int32_t>(Device::cpu(1), 10, 0).take(), LogicError);
}

TEST(BlockPool, ABlockThatGoesServesAgain) {
  BlockPool<int32_t> pool(Device::cpu(1), 10, 2);
  auto first = pool.take();
  std::set<const int32_t*> seen = {first.get()};
  for (int i = 0; i < 100; ++i) {
    auto next = pool.take();
    seen.insert(next.get());
    EXPECT_EQ(pool.free_blocks(), 0);
    first = std::move(next);
    EXPECT_EQ(pool.free_blocks(), 1);
  }
  EXPECT_EQ(seen.size(), 2u);
  first.reset();
  EXPECT_EQ(pool.free_blocks(), 2);
}

TEST(BlockPool, ABlockMayOutliveThePool) {
  std::optional<BlockPool<int32_t>> pool(std::in_place, Device::cpu(1), 10, 2);
  const auto block = pool->take();
  pool.reset();
  block.get()[9] = 7;
  EXPECT_EQ(block.get()[9], 7);
}

}  // namespace
}  // namespace kt::exec
