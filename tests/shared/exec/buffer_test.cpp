// Tests of device memory.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/exec/buffer.h"

#include <algorithm>
#include <numeric>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

#include "shared/core/vec.h"
#include "tests/support/devices.h"
#include "tests/support/resident_memory.h"

namespace kt::exec {
namespace {

TEST(Buffer, IsZeroedAtFirst) {
  for (const Device& device : test::parity_devices()) {
    // Within a page, within a huge page, over several of either; each after memory of that size was in use.
    for (const int64_t size : {1, 1000, 3'000'000}) {
      { Buffer<int32_t>(device, size).upload(std::vector<int32_t>(static_cast<size_t>(size), -1)); }
      const std::vector<int32_t> values = Buffer<int32_t>(device, size).downloaded();
      EXPECT_TRUE(std::all_of(values.begin(), values.end(), [](int32_t x) { return x == 0; }))
          << test::name_of(device) << ", " << size;
    }
  }
}

TEST(Buffer, GivesBackWhatWasUploaded) {
  std::vector<int32_t> values(1234);
  std::iota(values.begin(), values.end(), -7);
  for (const Device& device : test::parity_devices()) {
    Buffer<int32_t> buffer(device, 1234);
    buffer.upload(values);
    EXPECT_EQ(buffer.downloaded(), values);
    EXPECT_EQ(buffer.downloaded(3), (std::vector<int32_t>{-7, -6, -5}));
  }
}

// Of several of the blocks that copies to a GPU go through, of one, and of a part of one.
TEST(Buffer, TakesWhatTheHostChangesRightAfterwards) {
  for (const Device& device : test::parity_devices()) {
    for (const int64_t size : {5'000'003, 1'048'576, 7}) {
      std::vector<int32_t> values(static_cast<size_t>(size));
      std::iota(values.begin(), values.end(), 1);
      Buffer<int32_t> first(device, size), second(device, size);
      first.upload(values);
      for (int32_t& value : values) value = -value;
      second.upload(values);
      EXPECT_EQ(second.downloaded(), values);
      for (int32_t& value : values) value = -value;
      EXPECT_EQ(first.downloaded(), values) << test::name_of(device) << ", " << size;
    }
  }
}

TEST(Buffer, AStartedDownloadIsThereAfterTheWait) {
  for (const Device& device : test::parity_devices()) {
    Buffer<int32_t> buffer(device, 5);
    HostBuffer<int32_t> first(device, 5), second(device, 3), empty(device, 0);
    buffer.upload(std::vector<int32_t>{1, 2, 3, 4, 5});
    buffer.start_download(5, first);
    buffer.upload(std::vector<int32_t>{6, 7});
    buffer.start_download(3, second);
    buffer.start_download(0, empty);
    wait(device);
    EXPECT_THAT(std::span(first.data(), 5), testing::ElementsAre(1, 2, 3, 4, 5)) << test::name_of(device);
    EXPECT_THAT(std::span(second.data(), 3), testing::ElementsAre(6, 7, 3)) << test::name_of(device);
    EXPECT_THROW(buffer.start_download(4, second), LogicError);
    EXPECT_THROW(buffer.start_download(6, first), LogicError);
  }
}

// What is given back begins and ends within a page.
TEST(Buffer, GivesTheMemoryOfZerosBackAndStillReadsZeros) {
  constexpr int64_t kSize = 300'000, kFirst = 100'001, kCount = 150'003;
  Buffer<int32_t> buffer(Device::cpu(1), kSize);
  std::vector<int32_t> values(kSize, 7);
  std::fill_n(values.begin() + kFirst, kCount, 0);
  const auto resident = [&](int64_t first, int64_t count) {
    return test::resident_bytes(buffer.data() + first, static_cast<size_t>(count) * sizeof(int32_t));
  };
  EXPECT_EQ(resident(0, kSize), 0u);
  buffer.upload(values);
  const size_t all = resident(0, kSize);
  EXPECT_GT(all, size_t{kSize} * sizeof(int32_t) * 9 / 10);
  buffer.give_back_zeros(kFirst, kCount);
  EXPECT_EQ(resident(kFirst, kCount), 0u);
  EXPECT_GT(resident(0, kFirst), size_t{kFirst} * sizeof(int32_t) * 9 / 10);
  EXPECT_LT(resident(0, kSize), all / 2 + all / 20);
  EXPECT_EQ(buffer.downloaded(), values);
}

TEST(Buffer, GivingBackWorksOnEveryDeviceAndForAFewElements) {
  for (const Device& device : test::parity_devices()) {
    Buffer<int32_t> buffer(device, 100'000);
    std::vector<int32_t> values(100'000, 3);
    values[5] = values[6] = 0;
    std::fill(values.begin() + 1000, values.begin() + 90'000, 0);
    buffer.upload(values);
    buffer.give_back_zeros(5, 2);
    buffer.give_back_zeros(5, 0);
    buffer.give_back_zeros(1000, 89'000);
    EXPECT_EQ(buffer.downloaded(), values);
  }
}

TEST(Buffer, MovesItsMemory) {
  const Device device = Device::cpu(1);
  Buffer<int32_t> first(device, 4);
  first.upload(std::vector<int32_t>{1, 2, 3, 4});
  const int32_t* memory = first.data();
  Buffer<int32_t> second = std::move(first);
  EXPECT_EQ(second.data(), memory);
  second = Buffer<int32_t>(device, 2);
  EXPECT_EQ(second.size(), 2);
  EXPECT_FALSE(std::is_copy_constructible_v<Buffer<int32_t>>);
}

TEST(Buffer, MovedFromIsEmpty) {
  Buffer<int32_t> first(Device::cpu(1), 4);
  const Buffer<int32_t> second = std::move(first);
  EXPECT_EQ(first.size(), 0);  // NOLINT(bugprone-use-after-move): what is left is the point
  EXPECT_EQ(first.data(), nullptr);
}

TEST(Buffer, MayBeEmpty) {
  for (const Device& device : test::parity_devices()) {
    Buffer<float> buffer(device, 0);
    buffer.upload({});
    EXPECT_TRUE(buffer.downloaded().empty());
  }
}

TEST(Buffer, RefusesMoreThanItHolds) {
  Buffer<int32_t> buffer(Device::cpu(1), 2);
  std::vector<int32_t> three(3);
  EXPECT_THROW(buffer.upload(three), LogicError);
  EXPECT_THROW(buffer.download(three), LogicError);
}

TEST(Buffer, IsAlignedForItsType) {
  for (const int64_t size : {1, 3, 100'000}) {
    EXPECT_EQ(reinterpret_cast<uintptr_t>(Buffer<Vec4f>(Device::cpu(1), size).data()) % alignof(Vec4f), 0u);
  }
}

TEST(Buffer, SaysHowMuchMemoryIsMissing) {
  try {
    const Buffer<double> buffer(Device::cpu(1), int64_t{1} << 56);
    FAIL() << "half an exabyte cannot be had";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("memory"));
  }
}

}  // namespace
}  // namespace kt::exec
