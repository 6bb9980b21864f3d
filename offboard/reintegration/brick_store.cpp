// One place of fixed size in the file for each brick.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/reintegration/brick_store.h"

#include <algorithm>
#include <utility>

#include "shared/core/check.h"

namespace kt {
namespace {

constexpr auto kBytes = static_cast<int64_t>(sizeof(StoredBrick));
constexpr int32_t kInBlock = kBlockSide - 1;  // mask of the lowest bits
constexpr int kLog2BlockSide = 2;
static_assert(1 << kLog2BlockSide == kBlockSide);

size_t index_in_block(Vec3i brick) {
  return static_cast<size_t>(((brick.z & kInBlock) * kBlockSide + (brick.y & kInBlock)) * kBlockSide +
                             (brick.x & kInBlock));
}

}  // namespace

BrickStore::BrickStore(std::filesystem::path file) : file_(std::move(file), "the voxels of the whole map") {}

void BrickStore::put(std::span<const StoredBrick> bricks) {
  for (const StoredBrick& stored : bricks) {
    const Vec3i b = stored.brick;
    const auto [at, is_new] =
        blocks_.try_emplace({b.z >> kLog2BlockSide, b.y >> kLog2BlockSide, b.x >> kLog2BlockSide});
    if (is_new) at->second.fill(kNone);
    uint32_t& place = at->second[index_in_block(b)];
    if (place == kNone && free_.empty()) {
      KT_CHECK(end_ < kNone, "too many bricks");
      place = end_++;
    } else if (place == kNone) {
      place = free_.back();
      free_.pop_back();
    }
    file_.write_at(place * kBytes, std::as_bytes(std::span(&stored, 1)));
  }
}

// Calls visit(place) for each brick within.
template <typename Blocks, typename Visit>
void BrickStore::for_each_within(Blocks& blocks, const VoxelBounds& bounds, const Visit& visit) {
  auto at = blocks.lower_bound({bounds.low.z >> (kLog2BlockSide + kLog2BrickSide), INT32_MIN, INT32_MIN});
  for (; at != blocks.end() && at->first[0] * kBlockVoxels < bounds.high.z; ++at) {
    auto& [key, places] = *at;
    for (size_t i = 0; i < places.size(); ++i) {
      if (places[i] == kNone) continue;
      const auto k = static_cast<int32_t>(i);
      const Vec3i brick{key[2] * kBlockSide + (k & kInBlock),
                        key[1] * kBlockSide + (k / kBlockSide & kInBlock),
                        key[0] * kBlockSide + k / (kBlockSide * kBlockSide)};
      if (bounds.contains({brick.x * kBrickSide, brick.y * kBrickSide, brick.z * kBrickSide}))
        visit(places[i]);
    }
  }
}

void BrickStore::read(const VoxelBounds& bounds,
                      const std::function<void(std::span<const StoredBrick>)>& visit) const {
  constexpr size_t kAtOnce = 4096;
  std::vector<StoredBrick> bricks;
  for_each_within(blocks_, bounds, [&](uint32_t place) {
    file_.read_at(place * kBytes, std::as_writable_bytes(std::span(&bricks.emplace_back(), 1)));
    if (bricks.size() < kAtOnce) return;
    visit(bricks);
    bricks.clear();
  });
  if (!bricks.empty()) visit(bricks);
}

void BrickStore::erase(const VoxelBounds& bounds) {
  for_each_within(blocks_, bounds, [this](uint32_t& place) {
    free_.push_back(place);
    place = kNone;
  });
  std::erase_if(blocks_, [](const auto& block) {
    return std::all_of(block.second.begin(), block.second.end(),
                       [](uint32_t place) { return place == kNone; });
  });
}

std::vector<Vec3i> BrickStore::blocks() const {
  std::vector<Vec3i> all;
  for (const auto& [key, places] : blocks_) all.push_back({key[2], key[1], key[0]});
  return all;
}

}  // namespace kt
