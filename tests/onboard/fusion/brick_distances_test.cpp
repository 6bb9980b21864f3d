// Tests of the distances between bricks and surface against brute force.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/fusion/brick_distances.h"

#include <algorithm>
#include <cstdlib>
#include <vector>

#include "gtest/gtest.h"

#include "shared/core/rng.h"
#include "tests/support/devices.h"

namespace kt::test {
namespace {

// Along one axis of the ring.
int apart(int64_t a, int64_t b, int bricks) {
  const int straight = std::abs(static_cast<int>(a - b));
  return std::min(straight, bricks - straight);
}

int brute_force_distance(int64_t slot, const std::vector<int64_t>& surfaces, int64_t bricks) {
  int least = kFarthestBrick;
  for (const int64_t surface : surfaces) {
    const auto n = static_cast<int>(bricks);
    least = std::min(least, std::max({apart(slot % bricks, surface % bricks, n),
                                      apart(slot / bricks % bricks, surface / bricks % bricks, n),
                                      apart(slot / bricks / bricks, surface / bricks / bricks, n)}));
  }
  return least;
}

void expect_distances(int bricks, const std::vector<int64_t>& surfaces,
                      const std::vector<exec::Device>& devices) {
  const int64_t slots = int64_t{bricks} * bricks * bricks;
  std::vector<uint8_t> states(static_cast<size_t>(slots), kBrickObserved), expected;
  for (const int64_t slot : surfaces) states[static_cast<size_t>(slot)] = kBrickSurface;
  for (int64_t slot = 0; slot < slots; ++slot)
    expected.push_back(static_cast<uint8_t>(brute_force_distance(slot, surfaces, bricks)));
  for (const exec::Device& device : devices) {
    exec::Buffer<uint8_t> on_device(device, slots);
    on_device.upload(states);
    BrickDistances distances(device, bricks);
    distances.measure(on_device.data());
    EXPECT_EQ(distances.by_slot().downloaded(), expected)
        << surfaces.size() << " surfaces in " << bricks << " bricks per axis, " << name_of(device);
  }
}

TEST(BrickDistances, AreTheNearestSurfacesInChebyshevsMetricRoundTheRingOnEveryDevice) {
  const std::vector<exec::Device> devices = parity_devices();
  for (const int bricks : {4, 12, 64, 68}) {  // less than a word, a whole one, one and a bit
    for (const uint64_t count : {0u, 1u, 5u, 40u}) {
      const auto slots = static_cast<uint64_t>(int64_t{bricks} * bricks * bricks);
      std::vector<int64_t> surfaces;
      for (uint64_t k = 0; k < count; ++k)
        surfaces.push_back(static_cast<int64_t>(random_bits(count, 1, k) % slots));
      expect_distances(bricks, surfaces, devices);
    }
  }
}

TEST(BrickDistances, CrossTheBordersOfWordsOnEveryDevice) {
  const std::vector<exec::Device> devices = parity_devices();
  for (const int64_t x : {0, 61, 62, 63, 64, 66, 67}) expect_distances(68, {(5 * 68 + 30) * 68 + x}, devices);
}

}  // namespace
}  // namespace kt::test
