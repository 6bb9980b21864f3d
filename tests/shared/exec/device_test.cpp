// Tests of how a device is chosen.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/exec/device.h"

#include "gmock/gmock.h"
#include "gtest/gtest.h"

#include "shared/core/check.h"
#include "tests/support/devices.h"

namespace kt::exec {
namespace {

using testing::HasSubstr;

std::string error_of(const std::string& name, int threads) {
  try {
    Device::from_name(name, threads);
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

TEST(Device, TakesTheThreadsItIsGiven) {
  EXPECT_EQ(Device::cpu(3).threads(), 3);
  EXPECT_FALSE(Device::cpu(3).is_cuda());
  EXPECT_GE(Device::cpu(0).threads(), 1);
  EXPECT_EQ(Device::from_name("cpu", 5).threads(), 5);
}

TEST(Device, AutoIsTheGpuWhereThereIsOne) {
  const Device device = Device::from_name("auto", 3);
  EXPECT_EQ(device.is_cuda(), cuda_is_available());
  EXPECT_STREQ(device.name(), cuda_is_available() ? "cuda" : "cpu");
  EXPECT_EQ(device.threads(), device.is_cuda() ? 1 : 3);
}

TEST(Device, RefusesAbsurdThreadCounts) {
  for (const int threads : {-1, -1000, 1025, 1'000'000}) {
    EXPECT_THAT(error_of("cpu", threads),
                HasSubstr("threads must lie in [0, 1024], got " + std::to_string(threads)));
  }
}

TEST(Device, NamesTheChoicesForAnUnknownName) {
  for (const std::string name : {"", "gpu", "CPU", "opencl"})
    EXPECT_THAT(error_of(name, 1), HasSubstr("use auto, cpu or cuda"));
}

TEST(Device, WithoutAGpuSaysWhyAndWhatToDo) {
  std::string reason;
  if (cuda_is_available(&reason)) GTEST_SKIP() << "this machine has a usable GPU";
  EXPECT_FALSE(reason.empty());
  EXPECT_THAT(error_of("cuda", 0), testing::AllOf(HasSubstr(reason), HasSubstr("--device cpu")));
}

TEST(Device, WithAGpuIsCuda) {
  std::string reason;
  if (!cuda_is_available(&reason) && !test::is_cuda_required()) GTEST_SKIP() << reason;
  EXPECT_TRUE(reason.empty());
  EXPECT_TRUE(Device::cuda().is_cuda());
}

}  // namespace
}  // namespace kt::exec
