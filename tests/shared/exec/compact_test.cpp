// Tests of compaction and scan against the standard algorithms.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/exec/compact.h"

#include <limits>
#include <numeric>

#include "gtest/gtest.h"

#include "shared/core/rng.h"
#include "shared/exec/buffer.h"
#include "tests/support/devices.h"

namespace kt::exec {
namespace {

constexpr int64_t kCounts[] = {0, 1, 7, 8, 9, 255, 256, 257, 65'537};

template <typename T>
Buffer<T> on_device(const Device& device, const std::vector<T>& values) {
  Buffer<T> buffer(device, static_cast<int64_t>(values.size()));
  buffer.upload(values);
  return buffer;
}

TEST(CompactFlags, ListsTheSetOnesInOrder) {
  for (const Device& device : test::parity_devices()) {
    for (const int64_t count : kCounts) {
      for (const double share : {0.0, 0.01, 0.5, 1.0}) {
        std::vector<uint8_t> flags(static_cast<size_t>(count));
        std::vector<int32_t> expected;
        for (size_t i = 0; i < flags.size(); ++i) {
          // Any non-zero value counts as set.
          flags[i] = random_uniform(1, 0, i) < share ? static_cast<uint8_t>(1 + i % 255) : 0;
          if (flags[i]) expected.push_back(static_cast<int32_t>(i));
        }
        Buffer<int32_t> indices(device, count);
        const int64_t listed = compact_flags(device, on_device(device, flags).data(), count, indices.data());
        EXPECT_EQ(indices.downloaded(listed), expected) << test::name_of(device) << ", " << count;
      }
    }
  }
}

TEST(ExclusiveScan, EqualsTheStandardOne) {
  for (const Device& device : test::parity_devices()) {
    for (const int64_t count : kCounts) {
      std::vector<int32_t> counts(static_cast<size_t>(count)), expected(counts.size());
      for (size_t i = 0; i < counts.size(); ++i) counts[i] = static_cast<int32_t>(random_bits(2, 0, i) % 25);
      std::exclusive_scan(counts.begin(), counts.end(), expected.begin(), 0);
      Buffer<int32_t> offsets(device, count);
      const int64_t total = exclusive_scan(device, on_device(device, counts).data(), count, offsets.data());
      EXPECT_EQ(offsets.downloaded(), expected) << test::name_of(device) << ", " << count;
      EXPECT_EQ(total, std::accumulate(counts.begin(), counts.end(), int64_t{0}));
    }
  }
}

TEST(ExclusiveScan, RefusesATotalBeyond31Bits) {
  for (const Device& device : test::parity_devices()) {
    const std::vector<int32_t> counts(3, std::numeric_limits<int32_t>::max() / 2);
    Buffer<int32_t> offsets(device, 3);
    EXPECT_THROW(exclusive_scan(device, on_device(device, counts).data(), 3, offsets.data()), LogicError)
        << test::name_of(device);
    EXPECT_EQ(exclusive_scan(device, on_device(device, counts).data(), 2, offsets.data()),
              std::numeric_limits<int32_t>::max() - 1);
  }
}

}  // namespace
}  // namespace kt::exec
