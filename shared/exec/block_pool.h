// Blocks of device memory of one size, allocated at once and used again and again.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "shared/exec/buffer.h"

namespace kt::exec {

/// A fixed number of blocks. One that is taken returns by itself when its holder goes, before or after the
/// pool; what it held is still in it when it is taken again.
template <typename T>
class BlockPool {
  struct Memory {
    Buffer<T> all;
    std::vector<T*> free;
  };
  struct GiveBack {
    std::shared_ptr<Memory> memory;
    void operator()(T* block) const { memory->free.push_back(block); }  // never grows: reserved
  };

 public:
  /// Elements that belong to the holder; moves, does not copy.
  using Block = std::unique_ptr<T, GiveBack>;

  BlockPool(const Device& device, int64_t block_size, int64_t blocks)
      : memory_(std::make_shared<Memory>()), block_size_(block_size) {
    const int64_t stride = (block_size + kAlignment - 1) / kAlignment * kAlignment;
    memory_->all = {device, stride * blocks};
    memory_->free.reserve(static_cast<size_t>(blocks));
    for (int64_t i = blocks - 1; i >= 0; --i) memory_->free.push_back(memory_->all.data() + i * stride);
  }

  int64_t block_size() const { return block_size_; }
  int64_t free_blocks() const { return static_cast<int64_t>(memory_->free.size()); }
  Block take() {
    KT_CHECK(!memory_->free.empty(), "all blocks of the pool are taken");
    T* const block = memory_->free.back();
    memory_->free.pop_back();
    return Block(block, GiveBack{memory_});
  }

 private:
  static_assert(256 % sizeof(T) == 0);
  static constexpr int64_t kAlignment = 256 / sizeof(T);  // as cudaMalloc's

  std::shared_ptr<Memory> memory_;
  int64_t block_size_;
};

}  // namespace kt::exec
