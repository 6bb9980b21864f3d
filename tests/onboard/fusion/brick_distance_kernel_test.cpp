// Tests of the distances between bricks and surface against brute force.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/fusion/brick_distance_kernel.h"

#include <algorithm>
#include <cstdlib>
#include <vector>

#include "gtest/gtest.h"

#include "shared/core/rng.h"

namespace kt::test {
namespace {

constexpr int kBricks = 12;
constexpr int64_t kSlots = int64_t{kBricks} * kBricks * kBricks;

std::vector<uint8_t> distances_of(const std::vector<uint8_t>& states) {
  std::vector<uint8_t> distances(kSlots), along_x(kSlots), along_y(kSlots);
  for (int64_t i = 0; i < kSlots; ++i) StartBrickDistance{states.data(), distances.data()}(i);
  for (int round = 1; round < kFarthestBrick; ++round) {
    for (int64_t row = 0; row < kBricks * kBricks; ++row)
      SpreadBrickDistance{kBricks, 0, distances.data(), nullptr, along_x.data()}(row);
    for (int64_t row = 0; row < kBricks * kBricks; ++row)
      SpreadBrickDistance{kBricks, 1, along_x.data(), nullptr, along_y.data()}(row);
    for (int64_t row = 0; row < kBricks * kBricks; ++row)
      SpreadBrickDistance{kBricks, 2, along_y.data(), distances.data(), distances.data()}(row);
  }
  return distances;
}

// Along one axis of the ring.
int apart(int64_t a, int64_t b) {
  const int straight = std::abs(static_cast<int>(a - b));
  return std::min(straight, kBricks - straight);
}

TEST(BrickDistance, IsTheNearestSurfacesInChebyshevsMetricRoundTheRing) {
  for (const uint64_t surfaces : {0u, 1u, 5u, 40u}) {
    std::vector<uint8_t> states(kSlots, kBrickObserved);
    std::vector<int64_t> slots;
    for (uint64_t k = 0; k < surfaces; ++k)
      slots.push_back(static_cast<int64_t>(random_bits(surfaces, 1, k) % kSlots));
    for (const int64_t slot : slots) states[static_cast<size_t>(slot)] = kBrickSurface;
    const std::vector<uint8_t> distances = distances_of(states);
    for (int64_t i = 0; i < kSlots; ++i) {
      int expected = kFarthestBrick;
      for (const int64_t slot : slots) {
        const int d = std::max({apart(i % kBricks, slot % kBricks),
                                apart(i / kBricks % kBricks, slot / kBricks % kBricks),
                                apart(i / kBricks / kBricks, slot / kBricks / kBricks)});
        expected = std::min(expected, d);
      }
      ASSERT_EQ(distances[static_cast<size_t>(i)], expected) << i << " of " << surfaces;
    }
  }
}

}  // namespace
}  // namespace kt::test
