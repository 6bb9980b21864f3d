// Kernels that tell how far each brick is from the nearest surface, so that rays can leap over empty space.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstring>

#include "onboard/fusion/grid.h"

namespace kt {

/// Distances between bricks are Chebyshev's, in bricks, and end here: a brick at it has no surface nearer.
inline constexpr int kFarthestBrick = 4;

/// A set of bricks by slot: one bit for each brick of a row along x, in words of 64. Bricks are taken in ring
/// order, where the first and the last of an axis are neighbours too; that can only shorten a distance.
struct BrickSets {
  static constexpr int kWordBricks = 64;
  int32_t bricks;  // per axis

  KT_HOST_DEVICE int words_per_row() const { return (bricks + kWordBricks - 1) / kWordBricks; }
  KT_HOST_DEVICE int rows() const { return bricks * bricks; }
  KT_HOST_DEVICE int64_t words() const { return int64_t{rows()} * words_per_row(); }
  KT_HOST_DEVICE int bits(int word) const {
    const int left = bricks - word * kWordBricks;
    return left < kWordBricks ? left : kWordBricks;
  }
};

/// The bricks that hold surface; by word and row.
struct FindSurfaceBricks {
  BrickSets sets;
  const uint8_t* brick_states;
  uint64_t* surface;  // out

  KT_HOST_DEVICE void operator()(int word, int row) const {
    const uint8_t* states = brick_states + int64_t{row} * sets.bricks + word * BrickSets::kWordBricks;
    const int bits = sets.bits(word);
    uint64_t set = 0;
    for (int x = 0; x < bits; x += kBlockSide) set |= uint64_t{four_of(states + x)} << x;
    surface[int64_t{row} * sets.words_per_row() + word] = set;
  }

 private:
  // Bit k: whether brick k of four holds surface. The product brings bit 8 k to 24 + k.
  KT_HOST_DEVICE static uint32_t four_of(const uint8_t* states) {
    static_assert(kBlockSide == 4 && kBrickSurface == 2 && kBrickEmpty < 2 && kBrickObserved < 2);
    uint32_t four = 0;
    memcpy(&four, states, sizeof(four));
    return (four >> 1 & 0x01010101u) * 0x01020408u >> 24;
  }
};

/// The bricks of a set and their 26 neighbours; by word and row.
struct SpreadBricks {
  BrickSets sets;
  const uint64_t* input;
  uint64_t* output;

  KT_HOST_DEVICE void operator()(int word, int row) const {
    const int y = row % sets.bricks, z = row / sets.bricks;
    uint64_t spread = 0;
    for (int dz = -1; dz <= 1; ++dz) {
      for (int dy = -1; dy <= 1; ++dy) spread |= along_x(word, ring(z + dz) * sets.bricks + ring(y + dy));
    }
    output[int64_t{row} * sets.words_per_row() + word] = spread;
  }

 private:
  KT_HOST_DEVICE int ring(int at) const {
    return at < 0 ? at + sets.bricks : at >= sets.bricks ? at - sets.bricks : at;
  }
  KT_HOST_DEVICE uint64_t along_x(int word, int row) const {
    const int words = sets.words_per_row(), last = sets.bits(word) - 1;
    const int before = word > 0 ? word - 1 : words - 1, after = word < words - 1 ? word + 1 : 0;
    const uint64_t* set = input + int64_t{row} * words;
    const uint64_t here = set[word], from_before = set[before] >> (sets.bits(before) - 1),
                   from_after = (set[after] & 1) << last;
    return (here | here << 1 | here >> 1 | from_before | from_after) & ~uint64_t{0} >> (63 - last);
  }
};

/// Distances of four bricks: 0 in the first of kFarthestBrick sets, each of which is the one before it spread
/// once, k in the k-th after it and no earlier one; by four along x and row.
struct MeasureBrickDistance {
  BrickSets sets;
  const uint64_t* near_surface;  // set after set
  uint8_t* distances;            // out, by slot

  KT_HOST_DEVICE void operator()(int four, int row) const {
    const int x = four * kBlockSide;
    const uint64_t* word = near_surface + int64_t{row} * sets.words_per_row() + x / BrickSets::kWordBricks;
    uint32_t of_four = kFarthestBrick * kOnes;  // less one for each set that a brick is in
    for (int set = 0; set < kFarthestBrick; ++set) {
      const auto bits = static_cast<uint32_t>(word[set * sets.words()] >> (x % BrickSets::kWordBricks)) & 0xf;
      of_four -= bits * 0x00204081u & kOnes;  // the product brings bit k to 8 k
    }
    memcpy(distances + int64_t{row} * sets.bricks + x, &of_four, sizeof(of_four));
  }

 private:
  static constexpr uint32_t kOnes = 0x01010101u;
};

}  // namespace kt
