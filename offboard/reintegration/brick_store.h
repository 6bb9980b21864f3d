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

namespace kt {

class BrickStore {
 public:
  /// Makes the file, or replaces it; it is removed again in the end. Throws kt::Error where it cannot.
  explicit BrickStore(std::filesystem::path file);
  ~BrickStore();
  BrickStore(const BrickStore&) = delete;
  BrickStore& operator=(const BrickStore&) = delete;

  /// Keeps bricks; one that is there already is replaced. Throws kt::Error for a full disk.
  void put(std::span<const StoredBrick> bricks);

  /// Hands over those that begin in a box of global voxels, some at a time, ascending by z, y and x.
  void read(const VoxelBounds& bounds, const std::function<void(std::span<const StoredBrick>)>& visit) const;
  /// Forgets them.
  void erase(const VoxelBounds& bounds);

  /// All there are, by their global bricks; in the same order.
  std::vector<Vec3i> bricks() const;

 private:
  using Key = std::array<int32_t, 3>;  // z, y, x
  template <typename Visit>
  void for_each_within(const VoxelBounds& bounds, const Visit& visit) const;

  std::filesystem::path path_;
  int file_ = -1;
  std::map<Key, int64_t> places_;  // in the file, counted in bricks
  std::vector<int64_t> free_;      // of those that were erased
  int64_t end_ = 0;
};

}  // namespace kt
