// Tests that each element is visited once, on every device.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/exec/for_each.h"

#include "gtest/gtest.h"

#include "shared/exec/buffer.h"
#include "tests/shared/exec/exec_test_kernels.h"
#include "tests/support/devices.h"

namespace kt::exec {
namespace {

TEST(ForEach, VisitsEachElementOnce) {
  for (const Device& device : test::parity_devices()) {
    for (const int64_t count : {0, 1, 2, 31, 33, 4095, 4097, 100'003}) {
      Buffer<int64_t> slots(device, count + 1);
      for_each(device, count, test::AddIndex{slots.data()});
      const std::vector<int64_t> visited = slots.downloaded();
      for (int64_t i = 0; i < count; ++i)
        ASSERT_EQ(visited[static_cast<size_t>(i)], 1 + i) << test::name_of(device) << ", " << count;
      EXPECT_EQ(visited.back(), 0) << "visited past the end";
    }
  }
}

TEST(ForEachLane, VisitsEachElementOnce) {
  for (const Device& device : test::parity_devices()) {
    for (const int64_t count : {0, 8, 64, 100'008}) {
      Buffer<int64_t> slots(device, count + 1);
      for_each_lane(device, count, test::AddLaneIndex{slots.data()});
      const std::vector<int64_t> visited = slots.downloaded();
      for (int64_t i = 0; i < count; ++i)
        ASSERT_EQ(visited[static_cast<size_t>(i)], 1 + i) << test::name_of(device) << ", " << count;
      EXPECT_EQ(visited.back(), 0) << "visited past the end";
    }
  }
}

TEST(ForEachPixel, VisitsEachPixelOnceAsUV) {
  const struct { int width, height; } sizes[] = {{1, 1}, {1, 7}, {7, 1}, {33, 9}, {160, 120}, {0, 5}, {5, 0}};
  for (const Device& device : test::parity_devices()) {
    for (const auto [width, height] : sizes) {
      Buffer<int64_t> slots(device, int64_t{width} * height + 1);
      for_each_pixel(device, width, height, test::AddPixel{slots.data(), width});
      const std::vector<int64_t> visited = slots.downloaded();
      for (int v = 0; v < height; ++v) {
        for (int u = 0; u < width; ++u) {
          ASSERT_EQ(visited[static_cast<size_t>(v * width + u)], 1 + u + int64_t{1'000'000} * v)
              << test::name_of(device);
        }
      }
      EXPECT_EQ(visited.back(), 0) << "visited past the end";
    }
  }
}

}  // namespace
}  // namespace kt::exec
