// A shelf of free blocks for each class of sizes.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/core/recycling.h"

#include <algorithm>
#include <array>
#include <bit>
#include <mutex>

namespace kt {
namespace {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kRecycles = false;  // sanitizers see the wrong use of a block only once it is free
#else
constexpr bool kRecycles = true;
#endif

// Larger blocks are rare: their pages go back to the system.
constexpr size_t kLargestKept_bytes = 16u << 20, kMostKept_bytes = 32u << 20;  // of a shelf

// Sizes are rounded up to one of four steps between two powers of two.
constexpr int kSteps = 4, kFirstWidth = 6;  // 32 to 63 bytes
constexpr size_t kShelves =
    static_cast<size_t>(kSteps) * (std::bit_width(kLargestKept_bytes) - kFirstWidth) + 1;

struct SizeClass {
  size_t shelf;
  size_t bytes;
};

SizeClass class_of(size_t bytes) {
  const size_t size = std::max<size_t>(bytes, 32);
  const int width = std::bit_width(size - 1);  // size is at most 2^width
  const size_t step = size_t{1} << (std::max(width, kFirstWidth) - 3);
  const size_t rounded = (size + step - 1) / step * step;
  const size_t steps = rounded / step;  // 4 to 8
  return {static_cast<size_t>(std::max(width, kFirstWidth) - kFirstWidth) * kSteps + steps - kSteps, rounded};
}

struct FreeBlock {
  FreeBlock* next;
};

struct Shelf {
  FreeBlock* first = nullptr;
  size_t kept_bytes = 0;
};

struct Store {
  std::mutex mutex;
  std::array<Shelf, kShelves> shelves;
};

// Never destroyed: objects that outlive main give their blocks back, too.
Store& store() {
  static auto* const the_store = new Store;
  return *the_store;
}

bool is_kept(size_t bytes) { return kRecycles && bytes <= kLargestKept_bytes; }

}  // namespace

void* take_block(size_t bytes) {
  if (!is_kept(bytes)) return ::operator new(bytes);
  const SizeClass size = class_of(bytes);
  {
    Store& all = store();
    const std::lock_guard lock(all.mutex);
    Shelf& shelf = all.shelves[size.shelf];
    if (FreeBlock* const block = shelf.first) {
      shelf.first = block->next;
      shelf.kept_bytes -= size.bytes;
      return block;
    }
  }
  return ::operator new(size.bytes);
}

void give_back_block(void* block, size_t bytes) noexcept {
  if (is_kept(bytes)) {
    const SizeClass size = class_of(bytes);
    Store& all = store();
    const std::lock_guard lock(all.mutex);
    Shelf& shelf = all.shelves[size.shelf];
    if (shelf.kept_bytes + size.bytes <= kMostKept_bytes) {
      shelf.first = new (block) FreeBlock{shelf.first};
      shelf.kept_bytes += size.bytes;
      return;
    }
  }
  ::operator delete(block);
}

}  // namespace kt
