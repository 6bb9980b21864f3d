// Bricks of voxels in a file, so that a volume may be larger than memory.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <span>
#include <vector>

#include "onboard/fusion/stored_brick_kernel.h"
#include "shared/core/scratch_file.h"

namespace kt {

class BrickStore {
 public:
  /// Makes the file, or replaces it; it is removed again in the end. Throws kt::Error where it cannot.
  explicit BrickStore(std::filesystem::path file);

  /// Keeps bricks; one that is there already is replaced. Throws kt::Error for a full disk.
  void put(std::span<const StoredBrick> bricks);

  /// Hands over those that begin in a box of global voxels, some at a time, ascending by the z, y and x of
  /// their blocks (kBlockSide), and of the bricks within.
  void read(const VoxelBounds& bounds, const std::function<void(std::span<const StoredBrick>)>& visit) const;
  /// Forgets them.
  void erase(const VoxelBounds& bounds);

  /// The global blocks that hold any, in the same order.
  std::vector<Vec3i> blocks() const;

 private:
  static constexpr uint32_t kNone = ~uint32_t{0};
  using Key = std::array<int32_t, 3>;  // z, y, x
  using Places = std::array<uint32_t, size_t{kBlockSide} * kBlockSide * kBlockSide>;
  template <typename Blocks, typename Visit>
  static void for_each_within(Blocks& blocks, const VoxelBounds& bounds, const Visit& visit);

  ScratchFile file_;
  std::map<Key, Places> blocks_;  // where their bricks are in the file, counted in bricks
  std::vector<uint32_t> free_;    // places of bricks that were erased
  uint32_t end_ = 0;
};

}  // namespace kt
